"""What adapters in Python share: a case read, its numbers at hand, an answer written. Python's standard library only."""

import csv
import json
import pathlib
import platform
import sys


class Case:
    """A case.json, with what is asked on one refinement."""

    def __init__(self, path, refinement):
        self.json = json.loads(pathlib.Path(path).read_text())
        self.name = self.json["name"]
        self.given = self.json["given"]
        self.refinement = float(refinement)
        level = next(r for r in self.json["refinements"] if r["refinement"] == self.refinement)
        self.cell = level["cell_m"]
        self.wanted = {w["quantity"]: w for w in self.json["wanted"]}

    def get(self, path, default=None):
        """A number or word that is given, by its dotted path: `soil.porosity`."""
        value = self.given
        for key in path.split("."):
            if isinstance(value, list):
                value = value[int(key)] if int(key) < len(value) else None
            else:
                value = value.get(key) if isinstance(value, dict) else None
            if value is None:
                return default
        return float("inf") if value == "infinite" else value


def unable(case, why):
    """Ends with the reason why this code cannot answer the case."""
    sys.exit(f"{case.name}: not answered: {why}")


def write(folder, case, rows, code, version, settings):
    """Writes results.csv from rows (quantity, time_s, x_m, y_m, value), where x_m and y_m may be None, and run.json."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "results.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["refinement", "quantity", "time_s", "x_m", "y_m", "value"])
        for quantity, time, x, y, value in rows:
            place = ["" if at is None else repr(float(at)) for at in (x, y)]
            table.writerow([case.refinement, quantity, repr(float(time)), *place, repr(float(value))])
    said = {"code": code, "version": version, "settings": settings, "machine": platform.platform(terse=True)}
    (folder / "run.json").write_text(json.dumps(said, indent=2) + "\n")
