"""`fefinger live`: a finger that is pressed by hand in a page of the browser.

player.py    what is on the page to choose: finger, object, mechanics, units; and the finger in
             time: the hand or a preset moves the object; what is played is recorded
picture.py   what the page draws, as `pages/viewer.py`, of the present state
session.py   what the page may send, and a thread that steps the player and answers it
server.py    the page and its WebSocket, on the loopback address
"""
