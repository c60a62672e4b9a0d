//! A scene written as a file, so that one that was changed field by field is checked like any other.

use std::sync::Arc;

use toml::{Table, Value};

use super::patch::{Change, Source};
use super::{
    Bearing, CamClay, Coupling, Course, DarcyChoice, DomainChoice, Elastic, Feed, Fields, Initial, Integrator,
    Quadrature, Scene, SeedingChoice, Side, Soil, Stage, StepChoice, StrainChoice, Strength, TimeMethod,
    TransferChoice, Until, UpdateChoice, Waves, check,
};
use crate::error::SceneError;
use crate::water::retention::Retention;

impl Scene {
    /// The scene with some of its fields changed, written as a file and checked as one: a patch in types. Numbers keep all their
    /// bits, and times are those of the fields, in seconds, whatever time factors the file gave them by. Cells follow from
    /// the mesh. Inertia in Darcy's law and the least mass of nodes stay as they were, unless the scene has no use for them any
    /// more; so does what chooses a step.
    ///
    /// # Errors
    /// As [`Scene::patched`], among it fields of which the checker makes others: a number of cells that is not the height over
    /// the cell.
    pub fn edited(&self, edit: impl FnOnce(&mut Fields)) -> Result<Self, SceneError> {
        let mut fields = self.fields.clone();
        edit(&mut fields);
        self.with_fields(fields)
    }

    /// The scene with these fields, checked. [`Self::edited`] is generic and compiled for every edit; this is compiled once.
    fn with_fields(&self, mut fields: Fields) -> Result<Self, SceneError> {
        let follows = fields.darcy_inertia == self.darcy_inertia && self.darcy_inertia == self.usual_darcy_inertia();
        if follows && !fields.usual_darcy_inertia() {
            fields.darcy_inertia = false;
        }
        let follows = fields.light_nodes == self.light_nodes && self.light_nodes == self.sole_light_nodes();
        if follows && fields.sole_light_nodes() == 0.0 {
            fields.light_nodes = 0.0;
        }
        let (own_steps, given) = (fields.integrator.solves_displacements(), fields.step != StepChoice::Auto);
        if own_steps || given {
            fields.safety = check::SAFETY;
        }
        if !own_steps || given {
            fields.tolerance = check::TOLERANCE;
        }
        let mut scene = Scene::checked(&fields.source()?)?;
        (scene.fields.force, scene.fields.left_out) = (fields.force, fields.left_out.clone());
        match difference(&scene.fields, &fields, self) {
            Some([key, expected, found]) => Err(refused(&key, expected, found)),
            None => Ok(scene),
        }
    }

    /// The scene as a file that says all that it is made from, times in seconds. Numbers keep all their bits.
    ///
    /// # Errors
    /// A value that TOML cannot hold.
    pub fn text(&self) -> Result<String, SceneError> {
        Ok(self.fields.written()?.to_string())
    }

    /// The scene with fields that no checker has seen, to find out what a solver does about a scene that cannot be written.
    #[doc(hidden)]
    pub fn altered_unchecked(mut self, alter: impl FnOnce(&mut Fields)) -> Self {
        alter(&mut self.fields);
        // What is patched or edited next is what was altered.
        let none = || Arc::new(Source { text: String::new().into(), file: None, edits: Vec::new() });
        self.source = self.fields.source().unwrap_or_else(|_| none());
        self
    }
}

fn refused(key: &str, expected: String, found: String) -> SceneError {
    SceneError::new((String::new(), 0), format!("patch: {key}"), expected, found)
}

/// The first field of which the checker makes another than an edit did: its name, what it has to be, what it is.
fn difference(checked: &Fields, edited: &Fields, before: &Fields) -> Option<[String; 3]> {
    if checked == edited {
        return None;
    }
    let [checked, edited, before] = [checked, edited, before].map(|fields| Table::try_from(fields).unwrap_or_default());
    let shown = |value: Option<&Value>| value.map_or_else(|| "none".to_owned(), Value::to_string);
    let mut keys = checked.keys().chain(edited.keys());
    let is_other = |key: &&String| {
        let [checked, edited, before] = [&checked, &edited, &before].map(|table| table.get(*key));
        checked != edited && edited != before
    };
    keys.find(is_other).map(|key| [key.clone(), shown(checked.get(key)), shown(edited.get(key))])
}

/// A file in the making.
#[derive(Default)]
struct Writer(Table);

impl Writer {
    /// Writes a key; `None` leaves it out.
    fn put(&mut self, key: &str, value: impl Into<Change>) -> Result<(), SceneError> {
        self.put_change(key, value.into())
    }

    /// The same for all types.
    fn put_change(&mut self, key: &str, value: Change) -> Result<(), SceneError> {
        let value = value.value();
        let value = value.map_err(|why| refused(key, "a value that TOML can hold".to_owned(), why.to_string()))?;
        let Some(value) = value else { return Ok(()) };
        let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
        let table = tables.split('.').filter(|name| !name.is_empty()).fold(&mut self.0, |table, name| {
            let inner = table.entry(name).or_insert_with(|| Value::Table(Table::new()));
            match inner {
                Value::Table(inner) => inner,
                _ => unreachable!("keys with others below them are tables"),
            }
        });
        table.insert(last.to_owned(), value);
        Ok(())
    }

    /// Writes the law of a soil.
    fn law(
        &mut self,
        key: &str,
        elastic: &Elastic,
        strength: Option<&Strength>,
        cam_clay: Option<&CamClay>,
    ) -> Result<(), SceneError> {
        let law = match (cam_clay, strength) {
            (Some(soil), _) => return self.put(&format!("{key}.modified_cam_clay"), soil),
            (None, Some(strength)) => {
                self.put(&format!("{key}.mohr_coulomb"), strength)?;
                "mohr_coulomb"
            }
            (None, None) => "linear_elastic",
        };
        self.put(&format!("{key}.{law}.youngs_modulus"), elastic.youngs_modulus)?;
        self.put(&format!("{key}.{law}.poisson_ratio"), elastic.poisson_ratio)
    }

    /// Writes course in time.
    fn course(&mut self, course: &Course) -> Result<(), SceneError> {
        match course {
            Course::Constant => Ok(()),
            Course::Ramp(time) => self.put("ramp_time", *time),
            Course::Times(times) => self.put("times", times),
            Course::Sine { mean, amplitude, period, phase } => {
                self.put("sine.mean", *mean)?;
                self.put("sine.amplitude", *amplitude)?;
                self.put("sine.period", *period)?;
                self.put("sine.phase", *phase)
            }
            Course::Wave { length, period } => {
                self.put("wave.length", *length)?;
                self.put("wave.period", *period)
            }
        }
    }

    /// Writes the soil of a layer or a region.
    fn soil(&mut self, soil: &Soil, is_wet: bool) -> Result<(), SceneError> {
        self.law("law", &soil.elastic, soil.strength.as_ref(), soil.cam_clay.as_ref())?;
        self.put("grain_density", soil.grain_density)?;
        self.put("porosity", soil.porosity)?;
        self.put("biot_coefficient", soil.biot.map(|biot| biot.coefficient))?;
        self.put("grain_bulk_modulus", soil.biot.map(|biot| biot.grain_bulk_modulus))?;
        self.put("hydraulic_conductivity", is_wet.then_some(soil.hydraulic_conductivity))?;
        self.put("anisotropy", is_wet.then_some(soil.anisotropy))?;
        self.put("bedding_angle", is_wet.then_some(soil.fabric.bedding_angle))?;
        self.put("kozeny_carman", is_wet.then_some(soil.fabric.kozeny_carman))?;
        self.put("start_k0", soil.k0)
    }

    /// Writes a key unless its value is the usual one.
    fn unless<T: Into<Change> + PartialEq>(&mut self, key: &str, value: T, usual: T) -> Result<(), SceneError> {
        if value == usual { Ok(()) } else { self.put(key, value) }
    }
}

impl Fields {
    /// Inertia in Darcy's law where a file does not say it.
    fn usual_darcy_inertia(&self) -> bool {
        self.integrator != Integrator::QuasiStatic && !self.inertia_feeds_waves()
    }

    /// Relative acceleration of the water where a file does not say it.
    fn usual_relative_acceleration(&self) -> bool {
        self.darcy_inertia && self.integrator == Integrator::Implicit && self.water.is_some()
    }

    /// Nodes that are too light where a file does not say it.
    fn sole_light_nodes(&self) -> f64 {
        Self { light_nodes: 0.0, ..self.clone() }.usual_light_nodes()
    }

    /// That file as what a scene is made from.
    fn source(&self) -> Result<Arc<Source>, SceneError> {
        let text = self.written()?.to_string().into();
        Ok(Arc::new(Source { text, file: None, edits: Vec::new() }))
    }

    /// The file that says all this.
    fn written(&self) -> Result<Table, SceneError> {
        let mut out = Writer::default();
        out.put("name", &self.name)?;
        out.put("dimension", self.dimension)?;
        out.put("start", self.start)?;
        out.put("start_velocity", self.start_velocity)?;
        out.put("start_k0", self.start_k0)?;
        if let Some(initial) = &self.initial {
            out.put("initial.table", &initial.table)?;
            let lines = Initial::KEYS.iter().zip(&initial.lines).filter(|(_, line)| !line.is_empty());
            for (key, line) in lines.filter(|_| initial.table.is_none()) {
                out.put(&format!("initial.{key}"), line)?;
            }
        }
        out.put("gravity", self.gravity)?;
        out.put("slope_angle", self.slope_angle)?;
        out.put("seismic_coefficient", self.seismic_coefficient)?;
        let shape = if self.outline.is_some() { "outline" } else { "column" };
        match &self.outline {
            Some(points) => out.put("geometry.outline.points", points)?,
            None => {
                out.put("geometry.column.height", self.height)?;
                out.put("geometry.column.width", self.width)?;
            }
        }
        out.unless(&format!("geometry.{shape}.inner_radius"), self.inner_radius, 0.0)?;
        self.mesh(&mut out)?;
        self.of_soil(&mut out)?;
        self.fluid(&mut out)?;
        self.sides(&mut out)?;
        self.method(&mut out)?;
        let stages = self.stages.iter().map(|stage| self.stage(stage)).collect::<Result<Vec<_>, _>>()?;
        out.put("stages", stages)?;
        if let Some(Until::Time(_)) = self.stages.last().map(|stage| stage.until) {
            out.put("observe.times", &self.observe_times)?;
        }
        out.unless("observe.history", self.history, 0)?;
        out.unless("observe.profiles", self.profiles, true)?;
        Ok(out.0)
    }

    fn mesh(&self, out: &mut Writer) -> Result<(), SceneError> {
        out.put("mesh.cell", self.cell)?;
        out.put("mesh.particles_per_cell", self.particles_per_cell)?;
        out.unless("mesh.empty_cells_above", self.empty_cells_above, 0)?;
        out.unless("mesh.empty_cells_beside", self.empty_cells_beside, 0)?;
        out.unless("mesh.seeding", self.seeding, SeedingChoice::default())?;
        out.unless("mesh.shift", self.shift, 0.0)?;
        out.put("mesh.displaced", self.displaced)
    }

    fn of_soil(&self, out: &mut Writer) -> Result<(), SceneError> {
        out.put("soil.grain_density", self.grain_density)?;
        out.put("soil.porosity", self.porosity)?;
        out.put("soil.biot_coefficient", self.biot.map(|biot| biot.coefficient))?;
        out.put("soil.grain_bulk_modulus", self.biot.map(|biot| biot.grain_bulk_modulus))?;
        out.put("soil.separation", self.separation)?;
        out.unless("soil.strain", self.strain, StrainChoice::Large)?;
        out.law("soil.law", &self.elastic, self.strength.as_ref(), self.cam_clay.as_ref())?;
        let mut layers = Vec::new();
        for layer in &self.layers {
            let mut out = Writer::default();
            out.put("up_to", layer.up_to)?;
            out.soil(layer, self.water.is_some())?;
            layers.push(out.0);
        }
        out.put("layers", Some(layers).filter(|layers| !layers.is_empty()))?;
        let mut regions = Vec::new();
        for region in &self.regions {
            let mut out = Writer::default();
            match region.levels {
                Some(levels) => out.put("levels", levels)?,
                None => out.put("polygon", &region.polygon)?,
            }
            out.soil(&region.soil, self.water.is_some())?;
            regions.push(out.0);
        }
        out.put("regions", Some(regions).filter(|regions| !regions.is_empty()))
    }

    fn fluid(&self, out: &mut Writer) -> Result<(), SceneError> {
        out.put("water", self.water)?;
        let Some(free) = &self.free_surface else { return Ok(()) };
        out.put("water.free_surface.saturation", free.saturation)?;
        out.put("water.free_surface.level", free.level)?;
        out.put("water.free_surface.wet", &free.wet)?;
        out.put("water.free_surface.suction", free.suction)?;
        match free.retention {
            Some(Retention::VanGenuchten { alpha, n, entry }) => {
                out.put("water.free_surface.retention.van_genuchten.alpha", alpha)?;
                out.put("water.free_surface.retention.van_genuchten.n", n)?;
                out.put("water.free_surface.retention.van_genuchten.entry", (entry > 0.0).then_some(entry))?;
            }
            Some(Retention::Gardner { alpha }) => out.put("water.free_surface.retention.gardner.alpha", alpha)?,
            Some(Retention::BrooksCorey { entry, index }) => {
                out.put("water.free_surface.retention.brooks_corey.entry", entry)?;
                out.put("water.free_surface.retention.brooks_corey.index", index)?;
            }
            None => {}
        }
        for (side, feed) in Side::ALL.into_iter().zip(free.feeds) {
            let key = |name| format!("water.free_surface.feed.{side}.{name}");
            match feed {
                Some(Feed::Head(head)) => match &free.heads[side as usize] {
                    Course::Times(heads) => out.put(&key("heads"), heads)?,
                    _ => out.put(&key("head"), head)?,
                },
                Some(Feed::Velocity { speed, height }) => {
                    out.put(&key("velocity"), speed)?;
                    // Rain falls on all soil under the sky.
                    out.put(&key("height"), (side != Side::Top).then_some(height))?;
                    if let Course::Times(times) = &free.courses[side as usize] {
                        out.put(&key("times"), times)?;
                    }
                }
                None => {}
            }
        }
        Ok(())
    }

    fn sides(&self, out: &mut Writer) -> Result<(), SceneError> {
        for (side, held) in Side::ALL.into_iter().zip(self.solid_sides) {
            let key = format!("boundaries.{side}");
            match side {
                Side::Left | Side::Right if self.periodic => out.put(&key, "periodic")?,
                Side::Bottom if self.base.is_some() => out.put(&key, "coulomb")?,
                _ => out.put(&key, held)?,
            }
        }
        if let Some(base) = &self.base {
            match base.slip_distance {
                Some(distance) => {
                    out.put("base.peak_angle", base.peak_angle)?;
                    out.put("base.residual_angle", base.residual_angle)?;
                    out.put("base.slip_distance", distance)?;
                }
                None => out.put("base.friction_angle", base.peak_angle)?,
            }
            out.put("base.adhesion", base.adhesion)?;
            out.put("base.memory", base.memory)?;
            out.put("base.normal_stress", base.normal_stress)?;
        }
        out.put("surcharge", self.surcharge)?;
        let (mut loads, mut reservoirs) = (Vec::new(), Vec::new());
        for load in &self.loads {
            let mut out = Writer::default();
            out.put("on", load.on)?;
            out.put("x", load.x)?;
            out.put("y", load.y)?;
            let Bearing::Traction { pressure, shear, water } = load.bearing else {
                if let Course::Times(levels) = &load.course {
                    out.put("levels", levels)?;
                }
                reservoirs.push(out.0);
                continue;
            };
            out.put("pressure", pressure)?;
            out.unless("shear", shear, 0.0)?;
            out.unless("water", water, false)?;
            out.course(&load.course)?;
            loads.push(out.0);
        }
        out.put("reservoirs", Some(reservoirs).filter(|list| !list.is_empty()))?;
        let mut plates = Vec::new();
        for plate in &self.plates {
            let mut out = Writer::default();
            out.put("on", plate.on)?;
            out.put("x", plate.x)?;
            out.put("y", plate.y)?;
            out.put("rough", plate.rough)?;
            out.put("displacement", plate.displacement)?;
            out.put("velocity", plate.velocity)?;
            out.course(&plate.course)?;
            plates.push(out.0);
        }
        out.put("plates", Some(plates).filter(|list| !list.is_empty()))?;
        let mut wells = Vec::new();
        for well in &self.wells {
            let mut out = Writer::default();
            out.put("at", well.at)?;
            out.put("rate", well.rate)?;
            out.course(&well.course)?;
            wells.push(out.0);
        }
        out.put("wells", Some(wells).filter(|list| !list.is_empty()))?;
        out.put("loads", Some(loads).filter(|loads| !loads.is_empty()))?;
        out.put("failure", &self.failure)
    }

    fn method(&self, out: &mut Writer) -> Result<(), SceneError> {
        out.put("scheme.shape", self.shape)?;
        // Each of the others goes with some scenes only: written is what is not usual.
        out.unless("scheme.darcy", self.darcy, DarcyChoice::Face)?;
        if self.water.is_some() {
            out.unless("scheme.darcy_inertia", self.darcy_inertia, self.usual_darcy_inertia())?;
            let usual = self.usual_relative_acceleration();
            out.unless("scheme.relative_acceleration", self.relative_acceleration, usual)?;
        }
        out.unless("scheme.flip", self.flip, 1.0)?;
        out.unless("scheme.light_nodes", self.light_nodes, self.sole_light_nodes())?;
        out.unless("scheme.transfer", self.transfer, TransferChoice::Plain)?;
        out.put("scheme.null_space_strain", self.null_space_strain)?;
        out.unless("scheme.particle_domain", self.particle_domain, DomainChoice::Point)?;
        out.unless("scheme.update", self.update, UpdateChoice::Usl)?;
        out.unless("scheme.quadrature", self.quadrature, Quadrature::Fitted)?;
        out.put("scheme.jump_penalty", self.jump_penalty)?;
        out.put("time.integrator", self.integrator)?;
        match self.step {
            StepChoice::Fixed(step) => out.put("time.step", step)?,
            StepChoice::Auto | StepChoice::Paper => out.put("time.step", self.step)?,
        }
        out.unless("time.safety", self.safety, check::SAFETY)?;
        out.unless("time.method", self.method, TimeMethod::Auto)?;
        out.unless("time.waves", self.waves, Waves::Auto)?;
        out.unless("time.tolerance", self.tolerance, check::TOLERANCE)
    }

    fn stage(&self, stage: &Stage) -> Result<Table, SceneError> {
        let mut out = Writer::default();
        out.put("name", &stage.name)?;
        let drained: Vec<_> = Side::ALL.into_iter().filter(|side| stage.drained[*side as usize]).collect();
        match (self.water, drained.is_empty()) {
            (None, true) => {}
            (_, false) => out.put("drained", drained)?,
            (Some(_), true) => out.put("drained", "none")?,
        }
        for (side, held) in Side::ALL.into_iter().zip(stage.solid_sides.iter().flatten()) {
            // What a word of its own holds is not for a stage to say.
            if *held != self.solid_sides[side as usize] {
                out.put(&format!("boundaries.{side}"), held)?;
            }
        }
        out.unless("damping", stage.damping, 0.0)?;
        out.unless("coupling", stage.coupling, Coupling::default())?;
        match stage.until {
            Until::PorePressure { within, everywhere, at_most } => {
                out.put("until.pore_pressure_within", within)?;
                out.put("until.everywhere", everywhere)?;
                out.put("until.at_most", at_most)?;
            }
            Until::Time(_) | Until::Rest { .. } => out.put("until", stage.until)?,
        }
        Ok(out.0)
    }
}
