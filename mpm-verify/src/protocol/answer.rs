//! The answers of this code, through the same interface as any other: `case.json` in, `results.csv` and `run.json` out.
//!
//! What is solved is what `case.json` gives; the method (mesh, scheme, steps) is that of the case of the suite.

use std::fs;
use std::path::Path;
use std::time::Instant;

use cpu_time::ThreadTime;
use mpm_core::constitutive::{Law, ModifiedCamClay, MohrCoulomb};
use mpm_core::failure::Search;
use mpm_core::run::run;
use mpm_core::scene::{CamClay, Elastic, Reduction, Scene, Strength, Until};
use serde_json::{Value as Json, json};

use super::case::{Case, Place, SCHEMA, chosen};
use super::export::CASE;
use super::given;
use super::results::{About, Cost, RESULTS, RUN, Row, Said, write};
use crate::cases::{infinite_slope, spin};
use crate::element::Element;
use crate::error::Error::{self, Found, Lacks};
use crate::manifest::Manifest;
use crate::slope;

/// A number of an element of soil.
type Read<'a, L> = &'a dyn Fn(&Element<L>) -> f64;

/// A `case.json` that was read.
#[derive(Debug)]
pub struct Question {
    json: Json,
    case: Case,
}

impl Question {
    /// Reads a `case.json`, or that of a folder.
    ///
    /// # Errors
    /// A file that cannot be read, or is of another form or of no case that is known here.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let path = if path.is_dir() { path.join(CASE) } else { path.to_owned() };
        let text = fs::read_to_string(&path).map_err(Error::at(&path))?;
        let json: Json = serde_json::from_str(&text).map_err(|why| Found(why.to_string()).of(path.display()))?;
        let expected = |key: &str, what: &str| Error::refused(format!("{}: {key}", path.display()), what, &json[key]);
        if json["schema"] != SCHEMA {
            return Err(expected("schema", SCHEMA));
        }
        let name = json["name"].as_str().ok_or_else(|| expected("name", "the name of a case"))?;
        let seed = json["seed"].as_u64().ok_or_else(|| expected("seed", "a whole number"))?;
        let mut case = chosen(&[name.to_owned()], seed)?.pop().ok_or(Lacks("case"))?;
        let listed: Vec<f64> =
            json["refinements"].as_array().into_iter().flatten().filter_map(|one| one["refinement"].as_f64()).collect();
        case.refinements.retain(|own| listed.contains(own));
        Ok(Self { case, json })
    }

    /// Name of the case.
    pub fn name(&self) -> &str {
        &self.case.name
    }

    /// Answers it on one refinement or on all.
    ///
    /// # Errors
    /// A run that could not be finished, or a file that cannot be written.
    pub fn answer(&self, folder: &Path, only: Option<f64>) -> Result<(), Error> {
        let asked: Vec<f64> =
            self.case.refinements.iter().copied().filter(|own| only.is_none_or(|only| only == *own)).collect();
        if asked.is_empty() {
            return Err(Error::refused(
                "--refinement",
                format!("one of {:?}", self.case.refinements),
                only.unwrap_or_default(),
            ));
        }
        let (mut levels, mut costs) = (Vec::new(), Vec::new());
        for refinement in asked {
            let (cpu, wall) = (ThreadTime::now(), Instant::now());
            levels.push((refinement, self.rows(refinement).map_err(|error| error.of(self.name()))?));
            costs.push(Cost {
                refinement,
                cpu_s: Some(cpu.elapsed().as_secs_f64()),
                wall_s: Some(wall.elapsed().as_secs_f64()),
                peak_mib: None,
            });
        }
        write(&folder.join(RESULTS), &self.case, &levels).map_err(|e| Found(e.to_string()).of(folder.display()))?;
        let scene = self.case.scene();
        let said = Said {
            code: "mpm-verify".to_owned(),
            about: About {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                settings: scene
                    .map_or(Json::Null, |scene| json!({ "integrator": scene.integrator, "shape": scene.shape })),
                machine: String::new(),
            },
            date: scene.map_or_else(String::new, |scene| Manifest::new(scene, 1).date),
            runs: costs,
        };
        let text = serde_json::to_string_pretty(&said).map_err(|e| Found(e.to_string()))?;
        let path = folder.join(RUN);
        fs::write(&path, text + "\n").map_err(Error::at(&path))
    }

    /// The numbers on a refinement.
    ///
    /// # Errors
    /// A run that could not be finished.
    pub fn rows(&self, refinement: f64) -> Result<Vec<Row>, Error> {
        if let Some(spec) = self.case.spec() {
            let method = self.case.scene().ok_or(Lacks("scene"))?;
            let scene = spec.on(&given::scene(&self.json["given"], method)?, refinement)?;
            return self.case.answers(&run(&scene, &mut |_| {})?.whole()?);
        }
        let values = match self.name() {
            "mc-triaxial" | "mc-plane-strain" => self.mohr_coulomb(refinement)?,
            "cam-clay-oedometer" => self.cam_clay(refinement)?,
            "rotation" => self.rotation(refinement)?,
            "infinite-slope-dry" | "infinite-slope-seepage" => vec![self.infinite(refinement)?],
            "collapse" => vec![self.collapse(refinement)?],
            _ => vec![self.slope(refinement)?],
        };
        let mut values = values.into_iter();
        let mut rows = Vec::new();
        for (quantity, wanted) in self.case.wanted.iter().enumerate() {
            let places: Vec<Option<[f64; 2]>> = match &wanted.place {
                Place::Given(places) => places.iter().copied().map(Some).collect(),
                _ => vec![None],
            };
            for time in &wanted.times {
                for place in &places {
                    let value = values.next().ok_or(Lacks("number"))?;
                    rows.push(Row { quantity, time: *time, place: *place, value, line: 0 });
                }
            }
        }
        Ok(rows)
    }

    /// A number that is given.
    fn number(&self, key: &str) -> Result<f64, Error> {
        let value = &self.json["given"][key];
        value.as_f64().ok_or_else(|| Error::refused(format!("given.{key}"), "a number", value))
    }

    /// Numbers along a path of so many equal increments, quantity by quantity.
    fn path<L: Law>(
        &self,
        element: &mut Element<L>,
        increments: f64,
        mut step: impl FnMut(&mut Element<L>) -> Result<(), Error>,
        read: &[Read<'_, L>],
    ) -> Result<Vec<f64>, Error> {
        let times = &self.case.wanted[0].times;
        let mut found = vec![Vec::new(); read.len()];
        // Between two increments the path is straight.
        let (mut before, mut now) = (vec![0.0; read.len()], read.iter().map(|read| read(element)).collect::<Vec<_>>());
        let (mut done, mut next) = (0.0, times.iter().peekable());
        while let Some(time) = next.peek() {
            let at = **time * increments;
            if at > done + 1e-9 {
                step(element)?;
                done += 1.0;
                before = std::mem::replace(&mut now, read.iter().map(|read| read(element)).collect());
                continue;
            }
            let share = (at - (done - 1.0)).clamp(0.0, 1.0);
            found.iter_mut().zip(before.iter().zip(&now)).for_each(|(all, (a, b))| all.push(a + share * (b - a)));
            next.next();
        }
        Ok(found.concat())
    }

    fn mohr_coulomb(&self, increments: f64) -> Result<Vec<f64>, Error> {
        let elastic =
            Elastic { youngs_modulus: self.number("youngs_modulus_pa")?, poisson_ratio: self.number("poisson_ratio")? };
        let strength = Strength {
            cohesion: self.number("cohesion_pa")?,
            friction_angle: self.number("friction_angle_deg")?,
            dilation_angle: self.number("dilation_angle_deg")?,
            tension_cutoff: None,
            dilation_fades_over: None,
        };
        let first = [
            self.number("first_stress_xx_pa")?,
            self.number("first_stress_yy_pa")?,
            self.number("first_stress_zz_pa")?,
            0.0,
        ];
        let mut element = Element::new(MohrCoulomb::new(&elastic, &strength), first);
        let driven = [0.0, -self.number("axial_shortening")? / increments, 0.0, 0.0];
        let free = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let deviator = |element: &Element<MohrCoulomb>| element.stress[0] - element.stress[1];
        if self.name() == "mc-plane-strain" {
            let across = |element: &Element<MohrCoulomb>| element.stress[2];
            return self.path(&mut element, increments, |e| e.step(&driven, &free[..1], &first), &[&deviator, &across]);
        }
        // Lateral strains are alike by symmetry: one free strain of both.
        let both = [[1.0, 0.0, 1.0, 0.0]];
        let volume = |element: &Element<MohrCoulomb>| element.strain[..3].iter().sum();
        self.path(&mut element, increments, |e| e.step(&driven, &both, &first), &[&deviator, &volume])
    }

    fn cam_clay(&self, increments: f64) -> Result<Vec<f64>, Error> {
        let pressure = self.number("first_pressure_pa")?;
        let soil = CamClay {
            lambda: self.number("lambda")?,
            kappa: self.number("kappa")?,
            poisson_ratio: self.number("poisson_ratio")?,
            critical_slope: self.number("critical_slope")?,
            preconsolidation: self.number("preconsolidation_pa")?,
            ..crate::exact::cam_clay::SOIL
        };
        let mut element = Element::new(ModifiedCamClay::new(&soil), [-pressure, -pressure, -pressure, 0.0]);
        let driven = [0.0, -self.number("vertical_strain")? / increments, 0.0, 0.0];
        let vertical = |element: &Element<ModifiedCamClay>| -element.stress[1];
        let ratio = |element: &Element<ModifiedCamClay>| element.stress[0] / element.stress[1];
        self.path(&mut element, increments, |e| e.step(&driven, &[], &[0.0; 4]), &[&vertical, &ratio])
    }

    fn rotation(&self, cells: f64) -> Result<Vec<f64>, Error> {
        let [Place::Given(places), _] = self.case.wanted.iter().map(|wanted| &wanted.place).collect::<Vec<_>>()[..]
        else {
            return Err(Lacks("places"));
        };
        let soil =
            Elastic { youngs_modulus: self.number("youngs_modulus_pa")?, poisson_ratio: self.number("poisson_ratio")? };
        let body = spin::Body {
            side: self.number("side_m")?,
            density: self.number("density_kg_m3")?,
            rate: self.number("angular_velocity_per_s")?,
            soil,
        };
        let found = body.places(cells as usize, &self.case.wanted[0].times, places)?;
        Ok((0..2).flat_map(|axis| found.iter().map(move |x| x[axis]).collect::<Vec<_>>()).collect())
    }

    fn infinite(&self, rows: f64) -> Result<f64, Error> {
        let base = crate::scenes::built_in("slope-seepage")?;
        let (depth, angle) = (self.number("vertical_depth_m")?, self.number("slope_deg")?);
        let height = depth * angle.to_radians().cos();
        let numbers = [
            ("slope_angle", angle),
            ("gravity", self.number("gravity_m_s2")?),
            ("soil.grain_density", self.number("grain_density_kg_m3")?),
            ("soil.porosity", self.number("porosity")?),
            ("soil.law.mohr_coulomb.youngs_modulus", self.number("youngs_modulus_pa")?),
            ("soil.law.mohr_coulomb.poisson_ratio", self.number("poisson_ratio")?),
            ("soil.law.mohr_coulomb.cohesion", self.number("cohesion_pa")?),
            ("soil.law.mohr_coulomb.friction_angle", self.number("friction_angle_deg")?),
            ("soil.law.mohr_coulomb.dilation_angle", self.number("dilation_angle_deg")?),
            ("water.hydraulic_conductivity", self.number("hydraulic_conductivity_m_s")?),
            ("water.bulk_modulus", self.number("water_bulk_modulus_pa")?),
            ("water.unit_weight", self.number("water_unit_weight_n_m3")?),
            ("water.free_surface.level", height),
            ("geometry.column.height", height),
            ("geometry.column.width", height / rows),
            ("mesh.cell", height / rows),
            // Water finds its level in some passages over the depth.
            ("stages.0.until.time", 10.0 * height / self.number("hydraulic_conductivity_m_s")? * 5e-4 / 0.894),
        ];
        let changes: Vec<(&str, mpm_core::scene::Change)> =
            numbers.iter().map(|(key, value)| (*key, (*value).into())).collect();
        infinite_slope::parallel(
            &base.patched(&changes)?,
            depth,
            self.number("share_of_depth_under_water")?,
            rows as usize,
        )
    }

    /// The scene that is given, with the method of that of the case, on so many cells.
    fn given(&self, refinement: f64) -> Result<Scene, Error> {
        let scene = given::scene(&self.json["given"], self.case.scene().ok_or(Lacks("scene"))?)?;
        Ok(scene.with_cell(scene.height / refinement)?)
    }

    fn slope(&self, refinement: f64) -> Result<f64, Error> {
        let scene = self.given(refinement)?;
        let search = Search { by: Reduction::Associated, within: 0.01, guess: 1.0 };
        let found = slope::State::after(&scene, 0.0)?.factor(&search, &mut |_, _| ())?.bracket;
        Ok(0.5 * (found.low + found.high))
    }

    fn collapse(&self, refinement: f64) -> Result<f64, Error> {
        let scene = self.given(refinement)?;
        let end = self.case.wanted[0].times[0];
        let scene = scene.edited(|scene| {
            scene.observe_times = vec![end];
            scene.stages.iter_mut().for_each(|stage| stage.until = Until::Time(end));
        })?;
        let run = run(&scene, &mut |_| {})?.whole()?;
        let reach = run.samples.last().ok_or(Lacks("sample"))?.state.reach[0];
        Ok((reach - scene.width) / scene.width)
    }
}
