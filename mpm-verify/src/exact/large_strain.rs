//! One-dimensional consolidation of large strain: settlement from a table, at the times of its rows.
//!
//! Assumptions: incompressible water and grains, no weight, no inertia; Cauchy stress sigma' = -M ln J with the stretch
//! J, constant conductivity k; a step load q, top drained. In the depth a of the undeformed column
//! `dJ/dt = (M/gamma_w) d/da (k J^-2 dJ/da)`: there is no closed form (Xie & Leo 2004 have one for k proportional to
//! J^2). The tables hold q/M = -ln 0.8 and -ln 0.7, final strains of 20 and 30 %; their column `S_kconst_m` comes from finite
//! volumes, extrapolated, and is converged to 1.5e-9.
//!
//! Sources: Gibson, England & Hussey 1967, Geotechnique 17(3); Xie & Leo 2004, Computers and Geotechnics 31(4).

use mpm_core::scene::Scene;

/// q/M and the tables, in the program so that it runs from any folder: final strains of 20 and 30 %.
const TABLES: [(f64, &str); 2] = [
    (0.223_143_551_314_209_7, include_str!("../../../reference-data/exact/05_large_strain_S_A.csv")),
    (0.356_674_943_938_732_45, include_str!("../../../reference-data/exact/05_large_strain_S_B.csv")),
];
/// Height H of the table's column, m.
const HEIGHT: f64 = 1.0;
/// A time is that of a row if it agrees to this share.
const SAME: f64 = 1e-9;

/// Rows of time factor and settlement over height.
#[derive(Debug, Clone, PartialEq)]
pub struct LargeStrain {
    height: f64,
    /// c_0/H^2 = k M/(gamma_w H^2), 1/s.
    rate: f64,
    /// T = c_0 t/H^2 and S/H.
    rows: Vec<[f64; 2]>,
}

impl LargeStrain {
    /// The column of a scene; `None` unless its load is that of the table and its water incompressible.
    pub fn new(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let modulus = scene.oedometer_modulus();
        let ratio = load.pressure / modulus;
        let drained = scene.stages.iter().all(|stage| stage.drained == [false, false, false, true]);
        let (_, table) = TABLES.iter().find(|(of_table, _)| (ratio / of_table - 1.0).abs() < SAME)?;
        let uniform = scene.is_plain_column() && scene.layers.is_empty();
        if !(load.ramp_time == 0.0 && drained && water.bulk_modulus.is_infinite() && uniform) {
            return None;
        }
        let rate = water.mobility() * modulus / (scene.height * scene.height);
        Some(Self { height: scene.height, rate, rows: rows(table)? })
    }

    /// Settlement of the surface at a time (s), m; `None` between the rows of the table.
    pub fn settlement(&self, time: f64) -> Option<f64> {
        let t = self.rate * time;
        let row = self.rows.iter().find(|row| (row[0] / t - 1.0).abs() < SAME)?;
        Some(row[1] * self.height)
    }
}

/// T and S/H of the table; `None` if it is not what its header says.
fn rows(table: &str) -> Option<Vec<[f64; 2]>> {
    let header = table.lines().find_map(|line| line.strip_prefix("# columns: "))?;
    let place = |name: &str| header.split(',').position(|column| column == name);
    let (time, settlement) = (place("T")?, place("S_kconst_m")?);
    let numbers = table.lines().filter(|line| !line.starts_with('#'));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |place: usize| cells.get(place)?.trim().parse::<f64>().ok();
        Some([number(time)?, number(settlement)? / HEIGHT])
    };
    numbers.map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        crate::scenes::built_in("terzaghi-large-strain").expect("the built-in scene")
    }

    #[test]
    fn every_observed_time_of_the_scene_is_a_row() {
        let (scene, table) = (scene(), LargeStrain::new(&scene()).expect("the table's column"));
        let settlements: Vec<f64> = scene
            .observe_times
            .iter()
            .map(|t| table.settlement(*t).unwrap_or_else(|| panic!("no row at {t} s")))
            .collect();
        assert_eq!(settlements.len(), 6);
        assert!(settlements.windows(2).all(|pair| pair[0] < pair[1]), "{settlements:?}");
        // Between 0 and the final strain of 20 %; early it is A sqrt(T) with A = 0.2597555837 from a similarity solution.
        assert!(settlements[5] < 0.2, "{settlements:?}");
        let early = table.settlement(1e-3 / table.rate).expect("the first row");
        assert!((early / (0.259_755_583_7 * 1e-3_f64.sqrt()) - 1.0).abs() < 1e-9, "{early}");
    }

    #[test]
    fn nothing_is_read_between_the_rows_or_for_another_load() {
        let mut scene = scene();
        let table = LargeStrain::new(&scene).expect("the table's column");
        assert_eq!(table.settlement(scene.observe_times[0] * 1.001), None);
        assert_eq!(table.settlement(0.0), None);
        scene = scene.edited(|scene| scene.elastic.youngs_modulus *= 1.001).expect("a sound scene");
        assert_eq!(LargeStrain::new(&scene), None);
    }
}
