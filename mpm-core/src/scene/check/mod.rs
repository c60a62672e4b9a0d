//! From the raw file to a checked [`Scene`]: every bound, every default, and every message about them.

use std::ops::Range;
use std::sync::Arc;

use toml::de::DeValue;
use toml::{Spanned, Value};

mod failure;
mod faults;
mod features;
mod free_surface;
mod ground;
mod initial;
mod law;
mod loads;
mod method;
mod soils;
pub use method::{INTEGRATORS, SHAPES};
pub(super) use method::{SAFETY, TOLERANCE};
mod together;
mod units;

use super::decode::{Decode, Misfit, What};
use super::patch::{Source, Unreadable, correct};
use super::raw::{RawBoundaries, RawMesh, RawObserve, RawScene, RawStage, RawStrip, RawUntil, RawWater};
use super::renames::Renamed;
use super::{
    Dimension, Fabric, Fields, Integrator, LoadOn, LoadedStrip, Scene, Side, SolidSide, Stage, Start, Surcharge, Until,
    WaterProperties,
};
use crate::error::{SceneError, Warning};
use crate::order::sort_by_number;
use faults::{Faults, MOST_FAULTS, nearest};

/// Longest name of a scene, characters.
const LONGEST_NAME: usize = 64;
/// Longest part of what was found that a message repeats, characters.
const LONGEST_FOUND: usize = 200;
/// Memory that one soil point and one cell take at most, bytes: rounded up from what
/// `tests/all/allocation.rs` measures for both together.
const BYTES_PER_SOIL_POINT: f64 = 160.0;
const BYTES_PER_CELL: f64 = 200.0;
/// The same for quasi-static scenes, which keep stencils at their points, and a matrix with its factors: 36 kB per cell
/// were seen with B-splines, 9 particles and 96 x 96 cells.
const IMPLICIT_BYTES_PER_SOIL_POINT: f64 = 1100.0;
const IMPLICIT_BYTES_PER_CELL: [f64; 2] = [3_000.0, 30_000.0];
/// No length, time, modulus or density of this world is beyond: products of some of them are finite, and not zero.
const POSITIVE: [f64; 2] = [1e-30, 1e30];
/// Soil with fewer pores has none to speak of, and water with fewer grains is no soil.
const LEAST_PORES: f64 = 1e-6;
/// A run that needs more than this is refused before it starts, bytes.
const MEMORY_LIMIT: f64 = 16.0 * GIB;
const GIB: f64 = 1024.0 * 1024.0 * 1024.0;
/// Standard gravity used to turn a unit weight into a density, m/s2 (Table 1 of the paper uses the same).
const STANDARD_GRAVITY: f64 = 9.81;

type Checked<T> = Result<T, SceneError>;

/// Whether so many soil points and cells fit into the memory that a run may take; what was expected and found, if not.
pub(super) fn fits_in_memory(points: f64, cells: f64, implicit: bool, dim: Dimension) -> Result<(), [String; 2]> {
    let [per_point, per_cell] = if implicit {
        [IMPLICIT_BYTES_PER_SOIL_POINT, IMPLICIT_BYTES_PER_CELL[usize::from(dim != Dimension::Column)]]
    } else {
        [BYTES_PER_SOIL_POINT, BYTES_PER_CELL]
    };
    let bytes = points * per_point + cells * per_cell;
    if bytes <= MEMORY_LIMIT {
        return Ok(());
    }
    let expected = format!("a scene that fits into {:.0} GiB", MEMORY_LIMIT / GIB);
    Err([expected, format!("{points:.3e} particles in {cells:.3e} cells, which need {:.0} GiB", bytes / GIB)])
}

struct Reader<'a> {
    source: &'a Source,
}

/// The scene of a file and what was changed of it, and the place of its stages. A refusal has all faults that can be told apart.
pub(super) fn check(source: &Arc<Source>) -> Checked<(Scene, Range<usize>)> {
    let reader = Reader { source };
    let mut faults = Faults::default();
    let (raw, renamed) = reader.raw(&mut faults)?;
    let mut warnings: Vec<Warning> = renamed.iter().map(|old| reader.renamed(old)).collect();
    warnings.extend(raw.iter().flat_map(|raw| reader.units(raw)));
    sort_by_number(&mut warnings, |warning| warning.line as f64);
    let fields = raw.as_ref().and_then(|raw| faults.take(reader.scene(raw)));
    let checked = faults.or(fields.zip(raw)).map_err(|mut refusal| {
        if !warnings.is_empty() {
            refusal.notes_mut().warnings.clone_from(&warnings);
        }
        refusal
    });
    let (fields, raw) = checked?;
    Ok((Scene { fields, source: Arc::clone(source), warnings }, raw.stages.span()))
}

/// Refuses what is at a place.
pub(super) fn refused<T>(source: &Source, at: &Range<usize>, key: &str, expected: &str, found: String) -> Checked<T> {
    Reader { source }.refuse(at, key, expected, found)
}

/// In the words of a scene.
pub(super) fn unreadable(source: &Source, why: Unreadable) -> SceneError {
    match why {
        Unreadable::Text(error) => Reader { source }.syntax(&error),
        Unreadable::Edit(error) => error,
    }
}

impl Reader<'_> {
    fn line(&self, span: &Range<usize>) -> usize {
        // What is missing at the end of the file is missing on its last line.
        let text = &self.source.text;
        let line = 1 + text[..span.start.min(text.len())].matches('\n').count();
        line.min(text.lines().count().max(1))
    }

    fn refuse<T>(&self, span: &Range<usize>, key: &str, expected: &str, found: impl ToString) -> Checked<T> {
        Err(self.refusal(span, key, expected.to_owned(), clipped(found.to_string())))
    }

    fn refusal(&self, span: &Range<usize>, key: &str, expected: String, found: String) -> SceneError {
        // A value from the command line or a patch has no line, and what was written anew no file.
        let (file, line, key) = match (self.source.edit(span), &self.source.file) {
            (Some(edit), _) => (String::new(), 0, edit.named(key)),
            (None, Some(file)) => (file.to_string(), self.line(span), key.to_owned()),
            (None, None) => (String::new(), 0, format!("patch: {key}")),
        };
        SceneError::new((file, line), key, expected, found)
    }

    /// The tables of a file with the types that they must have. Keys that no table has are taken for those that they nearly are, or
    /// left out, and values of a wrong type are left out, each with a fault; `None` where this leads nowhere.
    fn raw(&self, faults: &mut Faults) -> Checked<(Option<RawScene>, Vec<Renamed>)> {
        let mut corrections: Vec<(Range<usize>, Option<String>)> = Vec::new();
        loop {
            let (mut table, renamed) = self.source.table().map_err(|why| unreadable(self.source, why))?;
            let all = corrections.iter().all(|(span, name)| correct(table.get_mut(), span, name.as_deref()));
            let misfit = match RawScene::decode(&DeValue::Table(table.into_inner()), &(0..self.source.text.len())) {
                Ok(raw) => return Ok((Some(raw), renamed)),
                Err(misfit) => misfit,
            };
            let is_missing = matches!(misfit.what, What::Missing(_));
            // What is missing now may be what was left out.
            if is_missing && corrections.iter().any(|(_, name)| name.is_none()) {
                return Ok((None, renamed));
            }
            let fault = self.misfit(&misfit);
            let meant = fault.notes.as_ref().and_then(|notes| notes.suggestion.clone());
            faults.take::<()>(Err(fault));
            let can_continue = all && !is_missing && corrections.len() < MOST_FAULTS;
            let Misfit { span, .. } = misfit;
            if !can_continue || self.source.edit(&span).is_some() || corrections.iter().any(|(known, _)| *known == span)
            {
                return Ok((None, renamed));
            }
            corrections.push((span, meant));
        }
    }

    fn renamed(&self, old: &Renamed) -> Warning {
        let [was, is] = old.names;
        self.warning(
            &old.span,
            &old.key,
            format!("`{was}` is now called `{is}`; the old name is accepted in this version only"),
        )
    }

    fn warning(&self, span: &Range<usize>, key: &str, what: String) -> Warning {
        let SceneError { file, line, key, .. } = self.refusal(span, key, String::new(), String::new());
        Warning { file, line, key, what }
    }

    /// A file that is not TOML.
    fn syntax(&self, error: &toml::de::Error) -> SceneError {
        let span = error.span().unwrap_or(self.source.text.len()..self.source.text.len());
        let message = error.message().replace('\n', ", ");
        let (expected, found) = match message.split_once(", expected ") {
            Some((found, "literal string")) => ("a number, or a word in quotes", found),
            Some((found, expected)) => (expected, found),
            None => ("a complete TOML scene, each key once", &*message),
        };
        self.refusal(&span, &self.key_at(&span), expected.to_owned(), found.to_owned())
    }

    /// A key or type that no scene has.
    fn misfit(&self, Misfit { span, what }: &Misfit) -> SceneError {
        let key = || self.source.edit(span).map_or_else(|| self.key_at(span), |edit| edit.key.clone());
        match what {
            What::Missing(field) => self.refusal(span, field, format!("the key `{field}`"), "none".to_owned()),
            What::Other { expected, found } => self.refusal(span, &key(), (*expected).to_owned(), found.clone()),
            What::Unknown { kind, name, known } => {
                let names: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
                let expected = format!("one of {}", names.join(", "));
                let mut fault = self.refusal(span, &key(), expected, format!("unknown {kind} `{name}`"));
                if let Some(name) = nearest(name, known) {
                    fault.notes_mut().suggestion = Some(name.to_owned());
                }
                fault
            }
        }
    }

    /// The key is what stands before the equals sign of the line, or the whole line of a table.
    fn key_at(&self, span: &Range<usize>) -> String {
        let text = &self.source.text;
        let start = text[..span.start.min(text.len())].rfind('\n').map_or(0, |end| end + 1);
        let line = text[start..].lines().next().unwrap_or("");
        let key = line.split('=').next().unwrap_or(line).trim();
        if key.is_empty() { "end of file" } else { key }.to_owned()
    }

    fn within(&self, value: &Spanned<f64>, key: &str, expected: &str, holds: impl Fn(f64) -> bool) -> Checked<f64> {
        let number = *value.get_ref();
        if number.is_finite() && holds(number) {
            return Ok(number);
        }
        self.refuse(&value.span(), key, expected, written(number))
    }

    /// A name may be that of a folder: it leads nowhere else.
    fn name(&self, value: &Spanned<String>) -> Checked<String> {
        let name = value.get_ref();
        let plain = |c: char| c.is_alphanumeric() || " -_.+".contains(c);
        let holds = (1..=LONGEST_NAME).contains(&name.chars().count())
            && name.chars().all(plain)
            && !name.starts_with(['.', ' '])
            && !name.ends_with(['.', ' ']);
        let expected = "a name of 1 to 64 letters, digits, spaces and - _ . +, with no dot or space at its ends";
        if holds { Ok(name.clone()) } else { self.refuse(&value.span(), "name", expected, quoted(name)) }
    }

    fn positive(&self, value: &Spanned<f64>, key: &str, unit: &str) -> Checked<f64> {
        let number = self.within(value, key, &format!("a finite number above 0 ({unit})"), |x| x > 0.0)?;
        let [low, high] = POSITIVE;
        if number >= low && number <= high {
            return Ok(number);
        }
        self.refuse(&value.span(), key, &format!("a number between {low:e} and {high:e} ({unit})"), written(number))
    }

    fn word<T: Copy>(&self, value: Option<&Spanned<String>>, key: &str, words: &[(&str, T)], default: T) -> Checked<T> {
        let Some(value) = value else { return Ok(default) };
        match words.iter().find(|(word, _)| word == value.get_ref()) {
            Some((_, choice)) => Ok(*choice),
            None => Err(self.no_such_word(value, key, &words.iter().map(|(word, _)| *word).collect::<Vec<_>>())),
        }
    }

    /// A word that is none of those that there are.
    fn no_such_word(&self, value: &Spanned<String>, key: &str, words: &[&str]) -> SceneError {
        let mut fault = self.refusal(&value.span(), key, one_of(words), clipped(quoted(value.get_ref())));
        if let Some(word) = nearest(value.get_ref(), words) {
            fault.notes_mut().suggestion = Some(word.to_owned());
        }
        fault
    }

    /// Exactly one of two keys.
    fn either<'v>(
        &self,
        table: &Range<usize>,
        key: &str,
        first: (&str, Option<&'v Spanned<f64>>),
        second: (&str, Option<&'v Spanned<f64>>),
    ) -> Checked<(bool, &'v Spanned<f64>)> {
        let expected = format!("exactly one of {} or {}", first.0, second.0);
        match (first.1, second.1) {
            (Some(value), None) => Ok((true, value)),
            (None, Some(value)) => Ok((false, value)),
            (None, None) => self.refuse(table, key, &expected, "neither"),
            (Some(_), Some(value)) => self.refuse(&value.span(), key, &expected, "both"),
        }
    }

    fn scene(&self, raw: &RawScene) -> Checked<Fields> {
        let mut faults = Faults::default();
        faults.take(self.goes_together(raw));
        let fields = self.values(raw, &mut faults);
        // What depends on several values is only checked once these are sound.
        let Some(mut scene) = fields.filter(|_| faults.is_empty()) else { return faults.or(None) };
        faults.set(&mut scene, |scene| &mut scene.free_surface, |scene| self.free_surface(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.initial, |scene| self.initial(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.darcy_inertia, |scene| self.soft_water(raw, scene));
        let wave = (scene.oedometer_modulus() / scene.mixture_density()).sqrt();
        faults.set(&mut scene, |scene| &mut scene.base, |scene| self.base(raw, 4.0 * scene.height / wave));
        if faults.take(self.stages(raw, &mut scene)).is_some() {
            faults.set(&mut scene, |scene| &mut scene.failure, |scene| self.failure(raw, scene));
            faults.take(self.observe(raw.observe.as_ref(), &mut scene));
        }
        faults.set(&mut scene, |scene| &mut scene.layers, |scene| self.layers(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.regions, |scene| self.regions(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.loads, |scene| self.loads(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.plates, |scene| self.plates(raw, scene));
        faults.set(&mut scene, |scene| &mut scene.wells, |scene| self.wells(raw, scene));
        if !faults.is_empty() {
            return faults.or(None);
        }
        if self.light_nodes(raw)?.is_none() {
            scene.light_nodes = scene.usual_light_nodes();
        }
        self.fits_together(raw, &scene)?;
        Ok(scene)
    }

    /// What a scene says with single values, or `None` with the faults of all that are out of bounds.
    fn values(&self, raw: &RawScene, faults: &mut Faults) -> Option<Fields> {
        let dimensions = [
            ("column", Dimension::Column),
            ("plane-strain", Dimension::PlaneStrain),
            ("axisymmetric", Dimension::Axisymmetric),
        ];
        let dimension = faults.take(self.word(raw.dimension.as_ref(), "dimension", &dimensions, Dimension::Column))?;
        let positive = |value| self.positive(value, "gravity", "m/s2, downwards; leave the key out for none");
        let gravity = faults.take(raw.gravity.as_ref().map(positive).transpose());
        let (mesh, soil) = (raw.mesh.get_ref(), raw.soil.get_ref());
        let geometry = faults.take(self.geometry(raw, dimension));
        let particles = geometry.as_ref().and_then(|geometry| {
            let [across, rows] = geometry.cells;
            faults.take(self.particles(raw, rows, across.saturating_add(geometry.empty_cells_beside), dimension))
        });
        let [width, height] = geometry.as_ref().map_or([f64::INFINITY, 1.0], |g| [g.width, g.height]);
        let law = faults.take(self.law("soil.law", &soil.law, raw, height));
        let porosity = faults.take(self.porosity(&soil.porosity, "soil.porosity"));
        let grains = (soil.biot_coefficient.as_ref(), soil.grain_bulk_modulus.as_ref());
        let biot = law.zip(porosity).and_then(|((elastic, ..), n)| faults.take(self.biot("soil", grains, &elastic, n)));
        let water = faults.take(raw.water.as_ref().map(|water| self.water(water)).transpose());
        let given = (soil.grain_density.as_ref(), soil.bulk_density.as_ref());
        let grain_density = water.zip(porosity).and_then(|(water, porosity)| {
            faults.take(self.grain_density("soil", &raw.soil.span(), given, porosity, water.as_ref()))
        });
        if let Some((gravity, water)) = gravity.zip(water) {
            faults.take(self.weight_of_water(raw, gravity, water.as_ref()));
        }
        let usual = [SolidSide::Roller, SolidSide::Roller, SolidSide::Fixed, SolidSide::Free];
        let solid_sides =
            faults.take(self.solid_sides((raw, dimension), raw.boundaries.as_ref(), ("boundaries", usual)));
        let surcharge = faults.take(self.surcharge(raw, width));
        let start = surcharge
            .zip(gravity)
            .and_then(|(surcharge, gravity)| faults.take(self.start(raw, gravity, surcharge.as_ref())));
        let scheme = faults.take(self.scheme(raw.scheme.as_ref().map(Spanned::get_ref)));
        let time = faults.take(self.time(raw.time.as_ref().map(Spanned::get_ref)));
        let places = faults.take(self.places(mesh));
        let ground = faults.take(self.ground(raw));
        let name = faults.take(self.name(&raw.name));
        let light_nodes = faults.take(self.light_nodes(raw));
        let seeding = faults.take(self.seeding(mesh));
        let strain = faults.take(self.strain(soil));
        let separation = law.and_then(|(_, strength, _)| faults.take(self.separation(soil, strength.as_ref())));
        let periodic = faults.take(self.periodic(raw));
        let ground::Geometry { outline, width, height, inner_radius, cell, cells, empty_cells_beside } = geometry?;
        let ((particles_per_cell, empty_cells_above), (elastic, strength, cam_clay)) = (particles?, law?);
        let (scheme, time, (shift, displaced), ground) = (scheme?, time?, places?, ground?);
        Some(Fields {
            name: name?,
            dimension,
            start: start?,
            start_velocity: ground.start_velocity,
            start_k0: ground.start_k0,
            initial: None,
            gravity: gravity?,
            slope_angle: ground.slope_angle,
            seismic_coefficient: ground.seismic_coefficient,
            height,
            width,
            inner_radius,
            light_nodes: light_nodes?.unwrap_or(0.0),
            outline,
            seeding: seeding?,
            cell,
            cells,
            empty_cells_above,
            empty_cells_beside,
            particles_per_cell,
            shift,
            displaced,
            strain: strain?,
            elastic,
            layers: Vec::new(),
            regions: Vec::new(),
            separation: separation?,
            strength,
            cam_clay,
            grain_density: grain_density?,
            porosity: porosity?,
            biot: biot?,
            water: water?,
            free_surface: None,
            failure: None,
            solid_sides: solid_sides?,
            periodic: periodic?,
            base: None,
            surcharge: surcharge?,
            loads: Vec::new(),
            plates: Vec::new(),
            wells: Vec::new(),
            integrator: time.integrator,
            method: time.method,
            waves: time.waves,
            tolerance: time.tolerance,
            quadrature: scheme.quadrature,
            jump_penalty: scheme.jump_penalty,
            shape: scheme.shape.unwrap_or_else(|| method::usual_shape(raw, dimension, time.integrator)),
            darcy: scheme.darcy,
            // A quasi-static soil has no acceleration that could enter Darcy's law.
            darcy_inertia: scheme.darcy_inertia && time.integrator != Integrator::QuasiStatic,
            relative_acceleration: scheme
                .relative_acceleration
                .unwrap_or(scheme.darcy_inertia && time.integrator == Integrator::Implicit && raw.water.is_some()),
            flip: scheme.flip,
            transfer: scheme.transfer,
            update: scheme.update,
            null_space_strain: scheme.null_space_strain,
            particle_domain: scheme.particle_domain,
            step: time.step,
            safety: time.safety,
            force: false,
            stages: Vec::new(),
            observe_times: Vec::new(),
            history: 0,
            profiles: true,
            left_out: Vec::new(),
        })
    }

    fn divides(&self, mesh: &RawMesh, cell: f64, length: f64, name: &str) -> Checked<usize> {
        let count = (length / cell).round();
        if count >= 1.0 && (count * cell - length).abs() <= 1e-9 * length {
            return Ok(count as usize);
        }
        if count >= 1e9 {
            let found = format!("{cell} m, {count:.1e} cells");
            return self.refuse(
                &mesh.cell.span(),
                "mesh.cell",
                &format!("fewer than 1e9 cells over the {name}"),
                found,
            );
        }
        let expected = format!("a cell that divides the {name} into whole cells");
        self.refuse(&mesh.cell.span(), "mesh.cell", &expected, format!("{cell} m ({} cells)", length / cell))
            .map_err(|fault| fault.with(format!("{name} {length} m")))
    }

    fn particles(&self, raw: &RawScene, rows: usize, across: usize, dim: Dimension) -> Checked<(usize, usize)> {
        let mesh = raw.mesh.get_ref();
        let value = &mesh.particles_per_cell;
        let count = *value.get_ref();
        let root = (count.max(0) as f64).sqrt().round();
        if count < 1 || root * root != count as f64 {
            let expected = "a square number of particles per cell: 1, 4, 9, ...";
            return self.refuse(&value.span(), "mesh.particles_per_cell", expected, count);
        }
        let per_cell = if dim == Dimension::Column { root } else { count as f64 };
        let above = mesh.empty_cells_above.as_ref().map_or(Ok(0), |h| match *h.get_ref() {
            rows @ 0..=1_000_000 => Ok(rows as usize),
            rows => self.refuse(&h.span(), "mesh.empty_cells_above", "between 0 and 1000000 rows of cells", rows),
        })?;
        let points = rows as f64 * across as f64 * per_cell;
        let cells = (rows as f64 + above as f64) * across as f64;
        let integrator = raw.time.as_ref().and_then(|time| time.get_ref().integrator.as_ref());
        let implicit = integrator.is_some_and(|word| ["quasi-static", "implicit"].contains(&word.get_ref().as_str()));
        if let Err([expected, found]) = fits_in_memory(points, cells, implicit, dim) {
            return self.refuse(&value.span(), "mesh.particles_per_cell", &expected, found);
        }
        Ok((count as usize, above))
    }

    fn porosity(&self, value: &Spanned<f64>, key: &str) -> Checked<f64> {
        self.within(value, key, "1e-6 <= n <= 0.999999", |n| (LEAST_PORES..=1.0 - LEAST_PORES).contains(&n))
    }

    /// Density of the grains of a soil in a table, from it or from a bulk density.
    fn grain_density(
        &self,
        table: &str,
        span: &Range<usize>,
        (grain, bulk): (Option<&Spanned<f64>>, Option<&Spanned<f64>>),
        n: f64,
        water: Option<&WaterProperties>,
    ) -> Checked<f64> {
        let key = format!("{table}.grain_density");
        let (is_grain, value) = self.either(span, &key, ("grain_density", grain), ("bulk_density", bulk))?;
        if is_grain {
            return self.positive(value, &key, "kg/m3");
        }
        // Saturated bulk density with water, dry bulk density without.
        let of_water = water.map_or(0.0, |w| n * w.density);
        let expected = "a bulk density above n rho_w, the share of the water in it (kg/m3)";
        let bulk = self.within(value, &format!("{table}.bulk_density"), expected, |rho| rho > of_water);
        let bulk = bulk.map_err(|fault| fault.with(format!("n rho_w = {of_water} kg/m3")))?;
        Ok((bulk - of_water) / (1.0 - n))
    }

    fn water(&self, table: &Spanned<RawWater>) -> Checked<WaterProperties> {
        let (water, span) = (table.get_ref(), table.span());
        let mut faults = Faults::default();
        let unit_weight = faults.take(self.positive(&water.unit_weight, "water.unit_weight", "N/m3"));
        let density = match &water.density {
            Some(value) => faults.take(self.positive(value, "water.density", "kg/m3")),
            None => unit_weight.map(|weight| weight / STANDARD_GRAVITY),
        };
        let hydraulic_conductivity = faults.take(self.conductivity(water, &span, unit_weight.unwrap_or(1.0)));
        let anisotropy = match &water.anisotropy {
            Some(value) => faults.take(self.positive(value, "water.anisotropy", "k_h/k_v")),
            None => Some(1.0),
        };
        let fabric = faults.take(self.fabric("water", &water.bedding_angle, &water.kozeny_carman, Fabric::default()));
        let bulk_modulus = *water.bulk_modulus.get_ref();
        if bulk_modulus.is_nan() || bulk_modulus <= 0.0 {
            let expected = "a number above 0 (Pa), or inf for incompressible water";
            faults.take::<()>(self.refuse(&water.bulk_modulus.span(), "water.bulk_modulus", expected, bulk_modulus));
        }
        let all = || {
            Some(WaterProperties {
                hydraulic_conductivity: hydraulic_conductivity?,
                anisotropy: anisotropy?,
                fabric: fabric?,
                bulk_modulus,
                unit_weight: unit_weight?,
                density: density?,
            })
        };
        faults.or(all())
    }

    /// Hydraulic conductivity (m/s), given as such or by permeability and viscosity beside a unit weight (N/m3).
    fn conductivity(&self, water: &RawWater, span: &Range<usize>, unit_weight: f64) -> Checked<f64> {
        let conductivity = ("hydraulic_conductivity", water.hydraulic_conductivity.as_ref());
        let intrinsic = ("intrinsic_permeability", water.intrinsic_permeability.as_ref());
        let (is_hydraulic, value) = self.either(span, "water.hydraulic_conductivity", conductivity, intrinsic)?;
        match (is_hydraulic, &water.viscosity) {
            (true, None) => self.positive(value, "water.hydraulic_conductivity", "m/s"),
            (true, Some(viscosity)) => {
                let expected = "no viscosity with a hydraulic conductivity, which contains it";
                self.refuse(&viscosity.span(), "water.viscosity", expected, viscosity.get_ref())
            }
            (false, None) => self.refuse(&value.span(), "water.viscosity", "a viscosity (Pa s) with it", "none"),
            (false, Some(viscosity)) => {
                let permeability = self.positive(value, "water.intrinsic_permeability", "m2")?;
                Ok(permeability * unit_weight / self.positive(viscosity, "water.viscosity", "Pa s")?)
            }
        }
    }

    /// Under gravity the water's density must be that of its unit weight.
    fn weight_of_water(&self, raw: &RawScene, gravity: Option<f64>, water: Option<&WaterProperties>) -> Checked<()> {
        let (Some(g), Some(water), Some(table)) = (gravity, water, &raw.water) else { return Ok(()) };
        if (water.density * g / water.unit_weight - 1.0).abs() <= 0.01 {
            return Ok(());
        }
        let span = table.get_ref().density.as_ref().map_or(table.get_ref().unit_weight.span(), Spanned::span);
        self.refuse(&span, "water.density", "density = unit_weight / gravity within 1 % (kg/m3)", water.density)
            .map_err(|fault| fault.with(format!("{:.6} kg/m3", water.unit_weight / g)))
    }

    /// Supports of the sides, as a table says or else as the defaults. A stage has no words for what only a side of the scene is.
    fn solid_sides(
        &self,
        (raw, dimension): (&RawScene, Dimension),
        table: Option<&Spanned<RawBoundaries>>,
        (key, defaults): (&str, [SolidSide; 4]),
    ) -> Checked<[SolidSide; 4]> {
        let words = [("free", SolidSide::Free), ("roller", SolidSide::Roller), ("fixed", SolidSide::Fixed)];
        let Some(table) = table else { return Ok(defaults) };
        let b = table.get_ref();
        let mut sides = defaults;
        for (side, value) in Side::ALL.into_iter().zip([&b.left, &b.right, &b.bottom, &b.top]) {
            let i = side as usize;
            let own = if key == "boundaries" { ground::own_words(side) } else { &[] };
            let words = [&words[..], own].concat();
            sides[i] = self.word(value.as_ref(), &format!("{key}.{side}"), &words, defaults[i])?;
            let across = matches!(side, Side::Left | Side::Right);
            if let (Some(value), true, Dimension::Column) = (value, across && sides[i] != SolidSide::Roller, dimension)
            {
                let expected = "\"roller\" in a column, which cannot move sideways (or dimension = \"plane-strain\")";
                return self.refuse(&value.span(), &format!("{key}.{side}"), expected, quoted(value.get_ref()));
            }
        }
        let pressed = raw.gravity.is_some() || raw.surcharge.is_some();
        if sides[Side::Bottom as usize] == SolidSide::Free && pressed {
            let span = b.bottom.as_ref().map_or(table.span(), Spanned::span);
            let expected = "\"roller\" or \"fixed\": a free column falls";
            return self.refuse(&span, &format!("{key}.bottom"), expected, "\"free\"");
        }
        Ok(sides)
    }

    fn surcharge(&self, raw: &RawScene, width: f64) -> Checked<Option<Surcharge>> {
        let Some(table) = &raw.surcharge else { return Ok(None) };
        let load = table.get_ref();
        let words = [("surface", LoadOn::Surface), ("particles", LoadOn::Particles), ("plate", LoadOn::Plate)];
        let ramp_time = match &load.ramp_time {
            Some(value) => self.within(value, "surcharge.ramp_time", "a time of 0 or more (s)", |t| t >= 0.0)?,
            None => 0.0,
        };
        Ok(Some(Surcharge {
            pressure: self.within(
                &load.pressure,
                "surcharge.pressure",
                "a finite pressure other than 0 (Pa)",
                |q| q != 0.0,
            )?,
            on: self.word(load.on.as_ref(), "surcharge.on", &words, LoadOn::Surface)?,
            ramp_time,
            strip: match &load.strip {
                Some(strip) => Some(self.strip(strip.get_ref(), width)?),
                None => None,
            },
        }))
    }

    fn strip(&self, strip: &RawStrip, width: f64) -> Checked<LoadedStrip> {
        let here = |fault: SceneError| fault.with(format!("width {width} m"));
        let expected = "0 <= from < the width (m)";
        let from = self.within(&strip.from, "surcharge.strip.from", expected, |x| (0.0..width).contains(&x));
        let from = from.map_err(here)?;
        let expected = "from < to <= the width (m)";
        let to = self.within(&strip.to, "surcharge.strip.to", expected, |x| x > from && x <= width).map_err(here)?;
        let taper = match &strip.taper {
            Some(value) => self.within(value, "surcharge.strip.taper", "a width of 0 or more (m)", |x| x >= 0.0)?,
            None => 0.0,
        };
        Ok(LoadedStrip { from, to, taper })
    }

    fn start(&self, raw: &RawScene, gravity: Option<f64>, surcharge: Option<&Surcharge>) -> Checked<Start> {
        let words = [
            ("unloaded", Start::Unloaded),
            ("undrained-equilibrium", Start::UndrainedEquilibrium),
            ("geostatic", Start::Geostatic),
            ("given", Start::Given),
        ];
        let start = self.word(raw.start.as_ref(), "start", &words, Start::Unloaded)?;
        let span = raw.start.as_ref().map_or(0..0, Spanned::span);
        match start {
            Start::UndrainedEquilibrium if surcharge.map_or(gravity.is_none(), |s| s.ramp_time > 0.0) => self.refuse(
                &span,
                "start",
                "gravity, or a surcharge without ramp, to be in equilibrium with",
                "\"undrained-equilibrium\"",
            ),
            start => Ok(start),
        }
    }

    fn stages(&self, raw: &RawScene, scene: &mut Fields) -> Checked<()> {
        let stages = raw.stages.get_ref();
        if stages.is_empty() {
            return self.refuse(&raw.stages.span(), "stages", "at least one [[stages]]", "none");
        }
        let mut faults = Faults::default();
        for (number, stage) in stages.iter().enumerate() {
            let drained = faults.take(self.drained(stage, scene)).unwrap_or_default();
            let damping = match &stage.get_ref().damping {
                Some(value) => {
                    let damping = self.within(value, "stages.damping", "a rate of 0 or more (1/s)", |d| d >= 0.0);
                    faults.take(damping).unwrap_or(0.0)
                }
                None => 0.0,
            };
            let (own, usual) = (stage.get_ref().boundaries.as_ref(), ("stages.boundaries", scene.solid_sides));
            let solid_sides = faults.take(self.solid_sides((raw, scene.dimension), own, usual));
            let solid_sides = solid_sides.filter(|sides| *sides != scene.solid_sides);
            let name =
                stage.get_ref().name.as_ref().map_or_else(|| format!("stage {}", number + 1), |n| n.get_ref().clone());
            let coupling = faults.take(self.coupling(stage.get_ref())).unwrap_or_default();
            let is_sound = faults.is_empty();
            scene.stages.push(Stage { name, drained, solid_sides, damping, coupling, until: Until::Time(0.0) });
            // A time factor needs to know what drains.
            let until = if is_sound { faults.take(self.until(&stage.get_ref().until, scene)) } else { None };
            if let (Some(last), Some(until)) = (scene.stages.last_mut(), until) {
                last.until = until;
            }
        }
        faults.or(Some(()))
    }

    fn drained(&self, stage: &Spanned<RawStage>, scene: &Fields) -> Checked<[bool; 4]> {
        let mut drained = [false; 4];
        let expected =
            "\"none\" or a list of sides, e.g. [\"top\"]: a saturated scene needs to say where its water drains";
        let Some(value) = &stage.get_ref().drained else {
            return if scene.water.is_none() {
                Ok(drained)
            } else {
                self.refuse(&stage.span(), "stages.drained", expected, "none given")
            };
        };
        let refuse = |expected: &str, found: String| self.refuse(&value.span(), "stages.drained", expected, found);
        let list = match value.get_ref() {
            Value::String(word) if word == "none" => return Ok(drained),
            Value::Array(list) if !list.is_empty() => list,
            other => return refuse(expected, other.to_string()),
        };
        for entry in list {
            let Some(side) = Side::ALL.into_iter().find(|side| entry.as_str() == Some(side.word())) else {
                return refuse(&one_of(&Side::ALL.map(Side::word)), entry.to_string());
            };
            if matches!(side, Side::Left | Side::Right) && scene.dimension == Dimension::Column {
                let expected = "\"top\" and \"bottom\" only: a column drains vertically";
                return refuse(expected, entry.to_string());
            }
            if matches!(side, Side::Left | Side::Right) && scene.periodic {
                let expected = "no \"left\" and \"right\" where these are periodic: they are the same place";
                return refuse(expected, entry.to_string());
            }
            if std::mem::replace(&mut drained[side as usize], true) {
                return refuse("each side once", format!("{entry} again"));
            }
        }
        Ok(drained)
    }

    fn until(&self, table: &Spanned<RawUntil>, scene: &Fields) -> Checked<Until> {
        let (until, span) = (table.get_ref(), table.span());
        if let Some(rest) = &until.rest {
            return self.rest(rest, until, &span);
        }
        if let (Some(value), None) = (&until.at_most, &until.pore_pressure_within) {
            return self.refuse(&value.span(), "stages.until.at_most", "pore_pressure_within with it", "none");
        }
        if let (Some(_), None) = (&until.everywhere, &until.pore_pressure_within) {
            return self.refuse(&span, "stages.until.everywhere", "pore_pressure_within with it", "none");
        }
        match (&until.time, &until.time_factor, &until.pore_pressure_within) {
            (Some(time), None, None) => Ok(Until::Time(self.positive(time, "stages.until.time", "s")?)),
            (None, Some(factor), None) => {
                let tv = self.positive(factor, "stages.until.time_factor", "-")?;
                if !scene.stages.last().is_some_and(|s| s.drained.contains(&true)) {
                    let expected = "a drained side: without one there is no drainage path and no time factor";
                    return self.refuse(&factor.span(), "stages.until.time_factor", expected, "drained nowhere");
                }
                match scene.time_per_factor() {
                    Some(seconds) => Ok(Until::Time(tv * seconds)),
                    None => self.refuse(&factor.span(), "stages.until.time_factor", "[water]", "a dry scene"),
                }
            }
            (None, None, Some(within)) => {
                if scene.surcharge.is_none() || scene.water.is_none() {
                    return self.refuse(
                        &within.span(),
                        "stages.until.pore_pressure_within",
                        "[surcharge] and [water]",
                        "none",
                    );
                }
                let expected = "0 < tolerance < 1";
                let key = "stages.until.pore_pressure_within";
                let within = self.within(within, key, expected, |t| t > 0.0 && t < 1.0)?;
                // Long enough for many passages of the undrained wave through any column.
                let passage = scene.height / (scene.pore_stiffness() / scene.mixture_density()).sqrt();
                let at_most = match &until.at_most {
                    Some(value) => self.positive(value, "stages.until.at_most", "s")?,
                    None => 200.0 * passage,
                };
                Ok(Until::PorePressure { within, everywhere: until.everywhere.unwrap_or(false), at_most })
            }
            (time, factor, within) => {
                let count = [time, factor, within].into_iter().flatten().count();
                let expected = "exactly one of time, time_factor, pore_pressure_within, rest";
                self.refuse(&span, "stages.until", expected, if count == 0 { "none" } else { "several" })
            }
        }
    }

    fn observe(&self, raw: Option<&Spanned<RawObserve>>, scene: &mut Fields) -> Checked<()> {
        let last = scene.stages[scene.stages.len() - 1].until;
        let Until::Time(end) = last else {
            let observe = raw.map(Spanned::get_ref);
            let span = observe.and_then(|o| {
                let lists = [&o.times, &o.time_factors].into_iter().flatten().map(Spanned::span).next();
                lists.or(o.history.as_ref().map(Spanned::span))
            });
            return match span {
                Some(span) => {
                    let by = if matches!(last, Until::Rest { .. }) { "rest" } else { "pressure" };
                    self.refuse(&span, "observe", &format!("no times with a last stage that ends by {by}"), "some")
                }
                None => Ok(()),
            };
        };
        let mut times = Vec::new();
        if let Some(table) = raw {
            let observe = table.get_ref();
            if let Some(list) = &observe.times {
                for value in list.get_ref() {
                    let time = self
                        .within(value, "observe.times", "0 < t <= the end of the stage (s)", |t| t > 0.0 && t <= end);
                    times.push(time.map_err(|fault| fault.with(format!("end {end} s")))?);
                }
            }
            if let Some(list) = &observe.time_factors {
                let Some(seconds) = scene.time_per_factor() else {
                    return self.refuse(&list.span(), "observe.time_factors", "[water]", "a dry scene");
                };
                let last = end / seconds;
                for value in list.get_ref() {
                    let fits = |tv: f64| tv > 0.0 && tv <= last * (1.0 + 1e-12);
                    let key = "observe.time_factors";
                    let time = self.within(value, key, "0 < Tv <= the end of the stage (-)", fits);
                    times.push(seconds * time.map_err(|fault| fault.with(format!("end {last}")))?);
                }
            }
            scene.profiles = observe.profiles.unwrap_or(true);
            scene.history = match &observe.history {
                Some(value) if (0..=1_000_000).contains(value.get_ref()) => *value.get_ref() as usize,
                Some(value) => {
                    return self.refuse(
                        &value.span(),
                        "observe.history",
                        "between 0 and 1000000 points",
                        value.get_ref(),
                    );
                }
                None => 0,
            };
        }
        times.push(end);
        times.sort_by(f64::total_cmp);
        times.dedup_by(|b, a| (*b - *a).abs() <= 1e-12 * end);
        scene.observe_times = times;
        Ok(())
    }
}

/// What was found, as far as a message repeats it: no more lines, and nothing that a terminal obeys.
fn clipped(found: String) -> String {
    let found: String =
        found.chars().flat_map(|c| if c.is_control() { c.escape_debug().collect() } else { vec![c] }).collect();
    match found.char_indices().nth(LONGEST_FOUND) {
        Some((end, _)) => format!("{} ... ({} bytes in all)", &found[..end], found.len()),
        None => found,
    }
}

fn quoted(word: &str) -> String {
    format!("\"{word}\"")
}

/// A number as one would write it: without rows of zeros.
fn written(number: f64) -> String {
    let size = number.abs();
    if size > 0.0 && !(1e-9..1e15).contains(&size) && number.is_finite() {
        format!("{number:e}")
    } else {
        number.to_string()
    }
}

fn one_of(words: &[&str]) -> String {
    let list: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    format!("one of {}", list.join(", "))
}
