//! A scene as data: what a file says, to be written, changed and written again.

use std::fmt::Write as _;

use mpm_core::error::SceneError;
use mpm_core::scene::Scene;

/// Names of the sides, in the order of every list over sides.
pub const SIDES: [&str; 4] = ["left", "right", "bottom", "top"];

/// Soil and its law.
#[derive(Debug, Clone, PartialEq)]
pub struct Soil {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Cohesion (Pa), angle of friction and of dilation (degrees); `None` for elastic soil.
    pub strength: Option<[f64; 3]>,
    /// Density of the grains, kg/m3.
    pub grain_density: f64,
    /// Whether the file gives the density of the mixture instead.
    pub by_bulk_density: bool,
    /// Porosity.
    pub porosity: f64,
    /// Whether `strain = "small"`.
    pub small: bool,
}

/// Water with a free surface.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSurface {
    /// Water that stays in the pores, share of them.
    pub saturation: f64,
    /// Level of the water at t = 0, m.
    pub level: Option<f64>,
    /// Heads at the sides, m.
    pub heads: [Option<f64>; 4],
}

/// Pore water.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    /// Hydraulic conductivity, m/s.
    pub conductivity: f64,
    /// The same written as an intrinsic permeability beside this viscosity, Pa s.
    pub viscosity: Option<f64>,
    /// Bulk modulus, Pa; may be infinite.
    pub bulk_modulus: f64,
    /// Unit weight, N/m3.
    pub unit_weight: f64,
    /// Density, kg/m3.
    pub density: f64,
    /// Where it is, if it does not fill the soil.
    pub free: Option<FreeSurface>,
}

/// A layer of soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Rows of cells.
    pub rows: usize,
    /// Young's modulus over that of the soil.
    pub stiffness: f64,
    /// Conductivity over that of the water.
    pub conductivity: f64,
}

/// A load on the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Pressure, Pa, positive downwards.
    pub pressure: f64,
    /// What carries it.
    pub on: &'static str,
    /// Ramp, s.
    pub ramp: f64,
    /// From, to and taper, m.
    pub strip: Option<[f64; 3]>,
}

/// A stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Sides that are drained.
    pub drained: [bool; 4],
    /// Rate of damping, 1/s.
    pub damping: f64,
    /// What moves, where water has a free surface.
    pub coupling: Option<&'static str>,
    /// Its length, s.
    pub time: f64,
    /// Whether the file gives its length as a time factor: s per unit of it.
    pub per_factor: Option<f64>,
}

/// A scene as it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Plane strain, or a column.
    pub plane: bool,
    /// State at t = 0.
    pub start: &'static str,
    /// Gravity, m/s2.
    pub gravity: Option<f64>,
    /// Corners of an outline, m.
    pub outline: Option<Vec<[f64; 2]>>,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Cells across and over the height.
    pub cells: [usize; 2],
    /// Width of a column, m.
    pub column_width: f64,
    /// Particles along one edge of a cell.
    pub per_direction: usize,
    /// Rows of empty cells above.
    pub empty_above: usize,
    /// Columns of empty cells at the right.
    pub empty_beside: usize,
    /// The soil.
    pub soil: Soil,
    /// Its layers.
    pub layers: Vec<Layer>,
    /// The water.
    pub water: Option<Water>,
    /// How the sides are held.
    pub sides: [&'static str; 4],
    /// The load.
    pub load: Option<Load>,
    /// `scheme.shape`.
    pub shape: Option<&'static str>,
    /// `scheme.darcy`.
    pub darcy: Option<&'static str>,
    /// `scheme.darcy_inertia`.
    pub darcy_inertia: Option<bool>,
    /// `scheme.flip`.
    pub flip: Option<f64>,
    /// `scheme.light_nodes`.
    pub light_nodes: Option<f64>,
    /// `scheme.transfer`.
    pub transfer: Option<&'static str>,
    /// `scheme.update`.
    pub update: Option<&'static str>,
    /// `scheme.quadrature`.
    pub quadrature: Option<&'static str>,
    /// `scheme.jump_penalty`.
    pub jump_penalty: Option<f64>,
    /// `time.integrator`.
    pub integrator: &'static str,
    /// `time.tolerance`.
    pub tolerance: Option<f64>,
    /// `time.waves`.
    pub waves: Option<&'static str>,
    /// `time.method`.
    pub method: Option<&'static str>,
    /// `time.step`, s.
    pub step: Option<f64>,
    /// The stages.
    pub stages: Vec<Stage>,
    /// Times of the last stage to observe, s.
    pub observed: Vec<f64>,
}

impl Written {
    /// Height of the soil, m.
    pub fn height(&self) -> f64 {
        self.cell * self.cells[1] as f64
    }

    /// Width of the soil, m.
    pub fn width(&self) -> f64 {
        if self.plane { self.cell * self.cells[0] as f64 } else { self.column_width }
    }

    /// What the scene is made of, in words by which scenes are counted.
    pub fn kind(&self) -> String {
        let dimension = match (self.plane, &self.outline) {
            (false, _) => "column",
            (true, None) => "plane strain",
            (true, Some(_)) => "outline",
        };
        let water = match &self.water {
            None => "dry",
            Some(water) if water.free.is_some() => "free surface",
            Some(_) => "saturated",
        };
        let law = if self.soil.strength.is_some() { ", Mohr-Coulomb" } else { "" };
        let strain = if self.soil.small { ", small strain" } else { "" };
        format!("{dimension}, {}, {water}{law}{strain}", self.integrator)
    }

    /// The checked scene.
    ///
    /// # Errors
    /// What the checker does not accept.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::parse(&self.toml(), "scene")
    }

    /// The text of the file. Numbers are written with all their digits, so that they are read as the same bits.
    pub fn toml(&self) -> String {
        let mut text = String::new();
        let out = &mut text;
        line(out, "name", "\"metamorphic\"");
        line(out, "dimension", if self.plane { "\"plane-strain\"" } else { "\"column\"" });
        if self.start != "unloaded" {
            line(out, "start", &format!("\"{}\"", self.start));
        }
        number(out, "gravity", self.gravity);
        match &self.outline {
            Some(points) => table(out, "geometry.outline", |out| line(out, "points", &format!("{points:?}"))),
            None => table(out, "geometry.column", |out| {
                number(out, "height", Some(self.height()));
                number(out, "width", Some(self.width()));
            }),
        }
        table(out, "mesh", |out| {
            number(out, "cell", Some(self.cell));
            line(out, "particles_per_cell", &(self.per_direction * self.per_direction).to_string());
            if self.empty_above > 0 {
                line(out, "empty_cells_above", &self.empty_above.to_string());
            }
            if self.empty_beside > 0 {
                line(out, "empty_cells_beside", &self.empty_beside.to_string());
            }
        });
        self.soil(out);
        let mut top = 0;
        for layer in &self.layers {
            top += layer.rows;
            table(out, "[layers]", |out| {
                number(out, "up_to", Some(self.cell * top as f64));
                number(out, "youngs_modulus", Some(self.soil.youngs_modulus * layer.stiffness));
                let conductivity = self.water.as_ref().map(|water| water.conductivity * layer.conductivity);
                number(out, "hydraulic_conductivity", conductivity);
            });
        }
        if let Some(water) = &self.water {
            self.water(water, out);
        }
        table(out, "boundaries", |out| {
            for (side, word) in SIDES.iter().zip(self.sides) {
                line(out, side, &format!("\"{word}\""));
            }
        });
        if let Some(load) = &self.load {
            table(out, "surcharge", |out| {
                number(out, "pressure", Some(load.pressure));
                line(out, "on", &format!("\"{}\"", load.on));
                number(out, "ramp_time", (load.ramp > 0.0).then_some(load.ramp));
                if let Some([from, to, taper]) = load.strip {
                    line(out, "strip", &format!("{{ from = {from:?}, to = {to:?}, taper = {taper:?} }}"));
                }
            });
        }
        self.scheme(out);
        for stage in &self.stages {
            self.stage(stage, out);
        }
        table(out, "observe", |out| line(out, "times", &format!("{:?}", self.observed)));
        text
    }

    fn soil(&self, out: &mut String) {
        let soil = &self.soil;
        table(out, "soil", |out| {
            if soil.by_bulk_density {
                let water = self.water.as_ref().map_or(0.0, |water| soil.porosity * water.density);
                number(out, "bulk_density", Some((1.0 - soil.porosity) * soil.grain_density + water));
            } else {
                number(out, "grain_density", Some(soil.grain_density));
            }
            number(out, "porosity", Some(soil.porosity));
            if soil.small {
                line(out, "strain", "\"small\"");
            }
        });
        let law = if soil.strength.is_some() { "soil.law.mohr_coulomb" } else { "soil.law.linear_elastic" };
        table(out, law, |out| {
            number(out, "youngs_modulus", Some(soil.youngs_modulus));
            number(out, "poisson_ratio", Some(soil.poisson_ratio));
            if let Some([cohesion, friction, dilation]) = soil.strength {
                number(out, "cohesion", Some(cohesion));
                number(out, "friction_angle", Some(friction));
                number(out, "dilation_angle", Some(dilation));
            }
        });
    }

    fn water(&self, water: &Water, out: &mut String) {
        table(out, "water", |out| {
            match water.viscosity {
                Some(viscosity) => {
                    let permeability = water.conductivity * viscosity / water.unit_weight;
                    number(out, "intrinsic_permeability", Some(permeability));
                    number(out, "viscosity", Some(viscosity));
                }
                None => number(out, "hydraulic_conductivity", Some(water.conductivity)),
            }
            number(out, "bulk_modulus", Some(water.bulk_modulus));
            number(out, "unit_weight", Some(water.unit_weight));
            number(out, "density", Some(water.density));
        });
        let Some(free) = &water.free else { return };
        table(out, "water.free_surface", |out| {
            number(out, "saturation", Some(free.saturation));
            number(out, "level", free.level);
        });
        if free.heads.iter().any(Option::is_some) {
            table(out, "water.free_surface.feed", |out| {
                for (side, head) in SIDES.iter().zip(free.heads) {
                    if let Some(head) = head {
                        line(out, side, &format!("{{ head = {head:?} }}"));
                    }
                }
            });
        }
    }

    fn scheme(&self, out: &mut String) {
        let word = |out: &mut String, key: &str, word: Option<&str>| {
            if let Some(word) = word {
                line(out, key, &format!("\"{word}\""));
            }
        };
        table(out, "scheme", |out| {
            word(out, "shape", self.shape);
            word(out, "darcy", self.darcy);
            if let Some(inertia) = self.darcy_inertia {
                line(out, "darcy_inertia", &inertia.to_string());
            }
            number(out, "flip", self.flip);
            number(out, "light_nodes", self.light_nodes);
            word(out, "transfer", self.transfer);
            word(out, "update", self.update);
            word(out, "quadrature", self.quadrature);
            number(out, "jump_penalty", self.jump_penalty);
        });
        table(out, "time", |out| {
            word(out, "integrator", Some(self.integrator));
            word(out, "method", self.method);
            number(out, "tolerance", self.tolerance);
            word(out, "waves", self.waves);
            number(out, "step", self.step);
        });
    }

    fn stage(&self, stage: &Stage, out: &mut String) {
        table(out, "[stages]", |out| {
            if self.water.is_some() {
                let sides: Vec<String> = SIDES.iter().zip(stage.drained).filter(|(_, d)| *d).map(quoted).collect();
                let none = || "\"none\"".to_owned();
                let list = if sides.is_empty() { none() } else { format!("[{}]", sides.join(", ")) };
                line(out, "drained", &list);
            }
            number(out, "damping", (stage.damping > 0.0).then_some(stage.damping));
            if let Some(coupling) = stage.coupling {
                line(out, "coupling", &format!("\"{coupling}\""));
            }
            match stage.per_factor {
                Some(seconds) => number(out, "until.time_factor", Some(stage.time / seconds)),
                None => number(out, "until.time", Some(stage.time)),
            }
        });
    }

    /// Leaves a share of all times.
    pub fn shorten(&mut self, share: f64) {
        self.stages.iter_mut().for_each(|stage| stage.time *= share);
        self.observed.iter_mut().for_each(|time| *time *= share);
        self.load.iter_mut().for_each(|load| load.ramp *= share);
    }

    /// The same scene in units that are `length`, `mass` and `time` times as small.
    pub fn in_units(&self, [length, mass, time]: [f64; 3]) -> Self {
        let pressure = mass / (length * time * time);
        let density = mass / (length * length * length);
        let mut to = self.clone();
        let by = |value: &mut f64, factor: f64| *value *= factor;
        by(&mut to.cell, length);
        by(&mut to.column_width, length);
        to.gravity.iter_mut().for_each(|g| by(g, length / (time * time)));
        to.outline.iter_mut().flatten().flatten().for_each(|x| by(x, length));
        by(&mut to.soil.youngs_modulus, pressure);
        by(&mut to.soil.grain_density, density);
        to.soil.strength.iter_mut().for_each(|s| by(&mut s[0], pressure));
        if let Some(water) = &mut to.water {
            by(&mut water.conductivity, length / time);
            water.viscosity.iter_mut().for_each(|mu| by(mu, pressure * time));
            by(&mut water.bulk_modulus, pressure);
            by(&mut water.unit_weight, pressure / length);
            by(&mut water.density, density);
            if let Some(free) = &mut water.free {
                free.level.iter_mut().for_each(|level| by(level, length));
                free.heads.iter_mut().flatten().for_each(|head| by(head, length));
            }
        }
        if let Some(load) = &mut to.load {
            by(&mut load.pressure, pressure);
            by(&mut load.ramp, time);
            load.strip.iter_mut().flatten().for_each(|x| by(x, length));
        }
        to.step.iter_mut().for_each(|step| by(step, time));
        for stage in &mut to.stages {
            by(&mut stage.damping, 1.0 / time);
            by(&mut stage.time, time);
            stage.per_factor.iter_mut().for_each(|seconds| by(seconds, time));
        }
        to.observed.iter_mut().for_each(|t| by(t, time));
        to
    }

    /// The same scene, left for right.
    pub fn mirrored(&self) -> Self {
        let mut to = self.clone();
        let across = self.cell * (self.cells[0] + self.empty_beside) as f64;
        if let Some(points) = &mut to.outline {
            points.iter_mut().for_each(|x| x[0] = across - x[0]);
            points.reverse();
            to.empty_beside = 0;
            to.cells[0] += self.empty_beside;
        }
        to.sides.swap(0, 1);
        to.stages.iter_mut().for_each(|stage| stage.drained.swap(0, 1));
        if let Some(free) = to.water.as_mut().and_then(|water| water.free.as_mut()) {
            free.heads.swap(0, 1);
        }
        if let Some([from, end, _]) = to.load.as_mut().and_then(|load| load.strip.as_mut()) {
            (*from, *end) = (across - *end, across - *from);
        }
        to
    }
}

fn quoted((side, _): (&&str, bool)) -> String {
    format!("\"{side}\"")
}

fn line(out: &mut String, key: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{key} = {value}");
}

fn number(out: &mut String, key: &str, value: Option<f64>) {
    if let Some(value) = value {
        line(out, key, &format!("{value:?}"));
    }
}

/// A table, left out where nothing is in it; a list of tables by a name in brackets.
fn table(out: &mut String, name: &str, fill: impl FnOnce(&mut String)) {
    let mut inside = String::new();
    fill(&mut inside);
    if !inside.is_empty() {
        let _ = write!(out, "\n[{name}]\n{inside}");
    }
}
