"""Answers cases of dry elastic soil with Kratos MPMApplication: material points on a grid of linear quadrilaterals.

Statics is its Static solver, dynamics its implicit Newmark solver. The grid is that of the case; the body fills whole
cells of it with 2 x 2 material points each. Loads and plates act on the nodes of the first surface.

    python kratos_mpm.py CASE.json OUT_DIR REFINEMENT
"""

import pathlib
import sys
import tempfile

import numpy as np

import KratosMultiphysics as Kratos
import KratosMultiphysics.LinearSolversApplication  # noqa: F401
import KratosMultiphysics.MPMApplication as Mpm
from KratosMultiphysics.MPMApplication.python_solvers_wrapper_mpm import CreateSolverByParameters

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from protocol import Case, unable, write  # noqa: E402

QUANTITIES = {"settlement", "plate_force", "strain_energy", "mean_stress"}
STEPS_PER_CELL = 2  # steps while a wave passes a cell

SETTINGS = """{
    "solver_type": "Static", "model_part_name": "MPM_Material", "domain_size": 2, "echo_level": 0,
    "analysis_type": "non_linear", "compute_reactions": true, "pressure_dofs": false,
    "grid_model_import_settings": {"input_type": "use_input_model_part"},
    "model_import_settings": {"input_type": "use_input_model_part"},
    "time_stepping": {"time_step": 1.0},
    "convergence_criterion": "residual_criterion", "max_iteration": 20,
    "residual_relative_tolerance": 1e-8, "residual_absolute_tolerance": 1e-9,
    "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"}
}"""


def check(case):
    """Refuses what is not solved here."""
    get = case.get
    refused = {
        "not a column or a plane section of one rectangle": get("dimension") not in ("column", "plane-strain")
        or list(case.given.get("geometry", {})) != ["column"] or get("layers") or get("cuts"),
        "it asks for " + ", ".join(case.wanted): not set(case.wanted) <= QUANTITIES,
        "pore water, which this code does not have": get("water"),
        "soil that is not linear elastic": "linear_elastic" not in get("soil.law", {}),
        "its start": get("start") != "unloaded",
        "gravity or several stages": get("gravity_m_s2") or len(get("stages", [])) != 1,
        "damping": get("stages.0.damping_per_s"),
        "loads other than a surcharge": get("loads"),
        "plates elsewhere than on the top, or with a course in time": any(
            plate["on"] != "top" or {"times", "sine"} & {*plate} for plate in get("plates", [])),
    }
    if any(refused.values()):
        unable(case, "; ".join(why for why, true in refused.items() if true))


class Model:
    """The model of a rectangle on its own grid."""

    def __init__(self, case):
        self.case, get = case, case.get
        self.cell, self.height, column = case.cell, get("geometry.column.height_m"), get("dimension") == "column"
        self.width = self.cell if column else get("geometry.column.width_m")  # of a column one strip of cells is enough
        self.columns, self.rows = (max(1, round(size / self.cell)) for size in (self.width, self.height))
        self.inertia = case.json["physics"]["inertia"]
        self.longest = self.step()
        settings = Kratos.Parameters(SETTINGS)
        if self.inertia:
            settings["solver_type"].SetString("Dynamic")
            settings.AddString("time_integration_method", "implicit")
            settings.AddString("scheme_type", "newmark")
        self.solver = CreateSolverByParameters(Kratos.Model(), settings, "OpenMP")
        self.solver.AddVariables()
        self.grid, body = self.solver.grid_model_part, self.solver.initial_mesh_model_part
        self.fill(self.grid.CreateSubModelPart("grid"))
        self.fill(body.CreateSubModelPart("body"))
        self.top = [self.grid.Nodes[self.node(column, self.rows)] for column in range(self.columns + 1)]
        loads = self.grid.CreateSubModelPart("loads")
        loads.AddNodes([node.Id for node in self.top])
        for at, node in enumerate(self.top):
            loads.CreateNewCondition("MPMGridPointLoadCondition2D1N", at + 1, [node.Id], self.grid.GetProperties()[0])
        self.solver.ImportModelPart()
        self.solver.PrepareModelPart()
        self.solver.AddDofs()
        self.hold()
        self.solver.Initialize()
        self.points = self.solver.material_point_model_part
        self.time, self.steps = 0.0, 0

    def step(self):
        """The longest step: a part of a wave's way through a cell, or the whole time in statics."""
        self.young, self.poisson = (self.case.get("soil.law.linear_elastic." + key)
                                    for key in ("youngs_modulus_pa", "poisson_ratio"))
        self.density = (1 - self.case.get("soil.porosity")) * self.case.get("soil.grain_density_kg_m3")
        modulus = self.young * (1 - self.poisson) / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return self.cell / np.sqrt(modulus / self.density) / STEPS_PER_CELL if self.inertia else np.inf

    def node(self, column, row):
        return 1 + row * (self.columns + 1) + column

    def fill(self, part):
        """Nodes, cells and soil."""
        for row in range(self.rows + 1):
            for column in range(self.columns + 1):
                place = column * self.width / self.columns, row * self.height / self.rows
                part.CreateNewNode(self.node(column, row), *place, 0.0)
        soil = part.GetProperties()[1]
        soil.SetValue(Kratos.CONSTITUTIVE_LAW, Mpm.LinearElasticIsotropicPlaneStrain2DLaw())
        soil.SetValue(Mpm.MATERIAL_POINTS_PER_ELEMENT, 4)
        soil.SetValue(Kratos.THICKNESS, 1.0)
        soil.SetValue(Kratos.DENSITY, self.density)
        soil.SetValue(Kratos.YOUNG_MODULUS, self.young)
        soil.SetValue(Kratos.POISSON_RATIO, self.poisson)
        for row in range(self.rows):
            for column in range(self.columns):
                corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
                part.CreateNewElement("Element2D4N", 1 + row * self.columns + column,
                                      [self.node(*corner) for corner in corners], soil)

    def hold(self):
        """Rollers, fixed sides and plates."""
        for node in self.grid.Nodes:
            sides = {"left": node.X < 1e-9, "right": node.X > self.width - 1e-9, "bottom": node.Y < 1e-9}
            for side, on in sides.items():
                kind = self.case.get("boundaries." + side)
                if kind != "free" and on:
                    for across in [side != "bottom"] if kind == "roller" else [True, False]:
                        node.Fix(Kratos.DISPLACEMENT_X if across else Kratos.DISPLACEMENT_Y)
        for plate in self.case.given.get("plates", []):
            for node in self.top:
                node.Fix(Kratos.DISPLACEMENT_Y)
                if plate.get("rough"):
                    node.Fix(Kratos.DISPLACEMENT_X)

    def pressure(self, x, time):
        """The surcharge at a place and time."""
        get = self.case.get
        ramp, pressure = get("surcharge.ramp_time_s", 0.0), get("surcharge.pressure_pa", 0.0)
        part = min(time / ramp, 1.0) if ramp else 1.0
        if get("surcharge.strip"):
            outside = np.maximum(get("surcharge.strip.from_m") - x, x - get("surcharge.strip.to_m")).clip(0.0)
            taper = get("surcharge.strip.taper_m") or 1e-12
            part = part * np.where(outside < taper, np.cos(np.pi / 2 * np.minimum(outside / taper, 1.0)) ** 2, 0.0)
        return pressure * part * np.ones_like(x)

    def forces(self, time):
        """The surcharge as forces on the nodes of the top, integrated with three points for each cell."""
        size, force = self.width / self.columns, np.zeros(self.columns + 1)
        for at, weight in zip(0.5 + np.array([-0.5, 0.0, 0.5]) * 0.6**0.5, np.array([5, 8, 5]) / 18):
            pressure = self.pressure((np.arange(self.columns) + at) * size, time) * size * weight
            force[:-1] += (1 - at) * pressure
            force[1:] += at * pressure
        return force

    def pressed(self, time):
        """How far the plates have moved down, where there are any."""
        down = 0.0
        for plate in self.case.given.get("plates", []):
            ramp = plate.get("ramp_time") or 1e-30
            down += plate["displacement_m"] * min(time / ramp, 1.0) + plate.get("velocity_m_s", 0.0) * time
        return down

    def advance(self, until):
        """Equal steps up to a time."""
        count = 1 if np.isinf(self.longest) else int(np.ceil((until - self.time) / self.longest))
        step, begin = (until - self.time) / count, self.time
        self.solver.settings["time_stepping"]["time_step"].SetDouble(step)
        for n in range(count):
            before, self.time = self.time, begin + (n + 1) * step
            self.solver.AdvanceInTime(before)
            for condition, force in zip(self.points.Conditions, self.forces(self.time)):
                condition.SetValue(Mpm.POINT_LOAD, [0.0, -force, 0.0])
            for node in self.top if self.case.given.get("plates") else []:
                node.SetSolutionStepValue(Kratos.DISPLACEMENT_Y, self.pressed(before) - self.pressed(self.time))
            self.solver.InitializeSolutionStep()
            self.solver.Predict()
            self.solver.SolveSolutionStep()
            self.solver.FinalizeSolutionStep()
        self.steps += count

    def of_points(self, variable):
        info = self.points.ProcessInfo
        return np.array([point.CalculateOnIntegrationPoints(variable, info)[0] for point in self.points.Elements])

    def read(self, quantity, time):
        """Rows of a quantity; settlement is continued from the two upper points of each column to the surface."""
        if quantity == "plate_force":
            value = sum(node.GetSolutionStepValue(Kratos.REACTION_Y) for node in self.top)
        elif quantity == "settlement":
            down = -self.of_points(Mpm.MP_DISPLACEMENT)[:, 1]
            place = self.of_points(Mpm.MP_COORD)[:, 1] + down
            upper, lower = np.unique(place.round(9))[:-3:-1]
            means = [down[abs(place - at) < 1e-8].mean() for at in (upper, lower)]
            value = means[0] + (means[0] - means[1]) * (self.height - upper) / (upper - lower)
        else:
            stress, volume = self.of_points(Mpm.MP_CAUCHY_STRESS_VECTOR), self.of_points(Mpm.MP_VOLUME)
            xx, yy, xy = stress[:, :3].T
            zz = self.poisson * (xx + yy)
            if quantity == "mean_stress":
                # the mean of the four points of a cell, which are made one cell after the other, is the better value
                places = self.of_points(Mpm.MP_COORD) - self.of_points(Mpm.MP_DISPLACEMENT)
                places, stress = places.reshape(-1, 4, 3).mean(axis=1), ((xx + yy + zz) / 3).reshape(-1, 4).mean(axis=1)
                return [(quantity, time, x, y, p) for (x, y, _), p in zip(places, stress)]
            squares = xx**2 + yy**2 + zz**2 + 2 * xy**2
            value = volume @ ((1 + self.poisson) * squares - self.poisson * (xx + yy + zz) ** 2) / (2 * self.young)
        return [(quantity, time, None, None, value)]


def main(path, folder, refinement):
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    case = Case(path, refinement)
    check(case)
    model, rows = Model(case), []
    for time, quantity in sorted((time, q) for q, wanted in case.wanted.items() for time in wanted["times_s"]):
        if time > model.time:
            model.advance(time)
        rows += model.read(quantity, time)
    settings = {"solver": "implicit Newmark" if model.inertia else "static", "points_per_cell": 4, "steps": model.steps}
    write(folder, case, rows, "Kratos MPMApplication", Kratos.Kernel.Version().split("-")[0].replace('"', ''), settings)


main(*sys.argv[1:])
