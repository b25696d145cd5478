"""
Soft and hard balls
===================

The same ball of 8 mm in four materials, pressed with the same force. A softer one is met by more
skin at less pressure: force against contact area tells them apart, and so do the spikes.

Two published findings to compare with. People discriminate moduli that differ by 15 % where the
surface gives way under the finger, and need more than three times as much where it does not
(Bergmann Tiest and Kappers, IEEE Trans. Haptics 2:189, 2009): what such a ball changes of the
contact is printed last. And a small soft ball cannot be told from a large stiff one by a passive
finger, to which it offers a similar contact (Xu, Wang and Gerling, PLOS Comput. Biol. 17:e1008848,
2021): the area of a smaller ball is less, as that of a stiffer one.
"""

import matplotlib.pyplot as plt

import fefinger as ff


finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")


def press(modulus, radius=8):
    """Press a ball of a modulus in kPa, rigid for None, and of a radius in mm."""
    scene = ff.Scene(
        finger=finger,
        indenter=ff.Sphere(radius, modulus=modulus),
        motion=ff.RampHold(loading_rate=1, force=0.25, hold=0.5),
        ask=ff.Ask(fields=False, spikes=("SAI", "FAI"), rel_error=0.9),
    )
    return ff.run(scene, mechanics="condensed")


def line(name, result):
    """Return what a press gives in a line."""
    area, pressure = result.contact_area[-1], result.pressure[-1].max()
    counts = dict(zip(result.spikes.types, result.spikes.count().tolist(), strict=True))
    return f"{name}: {area:.1f} mm², at most {pressure:.1f} kPa, {counts}"


results = {f"{modulus} kPa": press(modulus) for modulus in (10, 30, 100)} | {"rigid": press(None)}
fig, (curves, trains) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
for row, (name, result) in enumerate(results.items()):
    print(line(name, result))
    loading = result.time <= 0.25
    curves.plot(result.contact_area[loading], result.force[loading], label=name)
    for kind, times in zip(result.spikes.types, result.spikes.times, strict=True):
        color = "tab:blue" if kind == "SAI" else "tab:red"
        trains.eventplot(
            times, lineoffsets=row + 0.2 * (kind == "FAI"), linelengths=0.2, color=color
        )
curves.set(xlabel="contact area / mm²", ylabel="force / N", title="loading")
curves.legend()
trains.set(xlabel="time / s", title="SAI (blue) and FAI (red) under first touch")
trains.set_yticks(range(len(results)), results)
plt.show()

# %%
# A modulus 15 % higher, and a smaller ball:

print(line("115 kPa", press(115)))
print(line("30 kPa, 6 mm", press(30, radius=6)))
