"""`fefinger live`: a finger that is pressed by hand in a page of the browser.

setup.py     what is on the page to choose: finger, object, mechanics, units; and the loop of it
player.py    the finger in time: the hand or a preset moves the object; what is played is recorded
picture.py   what the page draws, as `pages/viewer.py`, of the present state
messages.py  what the page may send
session.py   a thread that steps the player against the clock and answers the page
server.py    the page and its WebSocket, on the loopback address
"""
