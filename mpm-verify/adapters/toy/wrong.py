"""The toy with a mistake planted, to see what a score makes of it: wrong.py MISTAKE CASE.json OUT_DIR REFINEMENT."""

import sys

from toy import answer


def scaled(key, factor):
    """Multiplies a number, or all numbers of a list."""
    def change(p):
        p[key] = [factor * value for value in p[key]] if isinstance(p[key], list) else factor * p[key]
    return change


def set_to(key, value):
    """Puts another value in the place of a number or of all numbers of a list."""
    def change(p):
        p[key] = [value] * len(p[key]) if isinstance(p[key], list) and key != "drained" else value
    return change


def modulus(p, s=0):
    """The oedometer modulus."""
    return p["E"][s] * (1 - p["nu"][s]) / ((1 + p["nu"][s]) * (1 - 2 * p["nu"][s]))


def without_storage(p):
    """k such that the coefficient of consolidation is k M/gamma_w."""
    p["k"] = [k * (1 + modulus(p, s) * p["n"][s] / p["Kw"]) for s, k in enumerate(p["k"])]


def swapped(p):
    """Solid volume fraction for porosity."""
    p["n"] = [1 - n for n in p["n"]]


def from_the_load(name, value, p, cells):
    """Settlement that counts from undrained equilibrium."""
    undrained = p["Kw"] / p["n"][0] / (modulus(p) + p["Kw"] / p["n"][0])
    return value - (1 - undrained) * p["q"] * p["H"] / modulus(p) if name == "settlement" else value


MISTAKES = {
    "incompressible": {"change": set_to("Kw", float("inf"))},
    "c_v-without-storage": {"change": without_storage},
    "path-halved": {"change": scaled("k", 4.0)},
    "path-doubled": {"change": scaled("k", 0.25)},
    "time-doubled": {"change": scaled("k", 2.0)},
    "unit-weight-as-density": {"change": scaled("gamma_w", 1 / 9.81)},
    "total-for-effective": {"change": scaled("k", 1e5)},
    "lateral-stress": {"change": set_to("nu", 0.0)},
    "porosity": {"change": swapped},
    "load-at-once": {"change": set_to("ramp", 0.0)},
    "load-doubled": {"change": scaled("q", 2.0)},
    "load-half-a-spacing-too-low": {"read": lambda name, v, p, n: v * (1 - 0.5 / n) if name == "settlement" else v},
    "sign": {"read": lambda name, v, p, n: -v},
    "from-the-loaded-state": {"read": from_the_load},
    "kilo": {"read": lambda name, v, p, n: 1e-3 * v},
    "both-ends": {"change": set_to("drained", ["top", "bottom"])},
}

if __name__ == "__main__":
    answer(*sys.argv[2:5], **MISTAKES[sys.argv[1]])
