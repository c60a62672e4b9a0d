//! A particle or a cell as a row of four-byte words.

use std::io::{self, Read};

use mpm_core::observe::{CellState, SolidState, WaterParticle};

/// What can be written as words.
pub trait Record: Sized {
    /// Names of the words, with units.
    const NAMES: &'static [&'static str];
    /// The words: numbers as the bits of four-byte floats, counts as they are.
    fn words(&self) -> Vec<u32>;
    /// The same read back.
    fn from_words(words: &[u32]) -> Self;
}

/// Reads `count` records.
pub fn layer<R: Record>(count: usize, file: &mut impl Read) -> io::Result<Vec<R>> {
    let mut bytes = vec![0; 4 * R::NAMES.len()];
    let one = |_| {
        file.read_exact(&mut bytes)?;
        let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        Ok(R::from_words(&words))
    };
    (0..count).map(one).collect()
}

fn bits(value: f64) -> u32 {
    (value as f32).to_bits()
}

fn number(word: u32) -> f64 {
    f64::from(f32::from_bits(word))
}

impl Record for SolidState {
    const NAMES: &'static [&'static str] = &[
        "id",
        "x_m",
        "y_m",
        "displacement_x_m",
        "displacement_y_m",
        "velocity_x_m_per_s",
        "velocity_y_m_per_s",
        "stress_xx_pa",
        "stress_yy_pa",
        "stress_zz_pa",
        "stress_xy_pa",
        "pore_pressure_pa",
        "deviator_strain",
        "volume_m3",
        "mass_kg",
    ];

    fn words(&self) -> Vec<u32> {
        let [s, x, u, v] = [&self.stress[..], &self.x, &self.displacement, &self.velocity];
        let rest = [self.pore_pressure, self.deviator_strain, self.volume, self.mass];
        let numbers = [x, u, v, s, &rest].concat();
        std::iter::once(self.id).chain(numbers.into_iter().map(bits)).collect()
    }

    fn from_words(words: &[u32]) -> Self {
        let at = |place: usize| number(words[place]);
        Self {
            id: words[0],
            x: [at(1), at(2)],
            displacement: [at(3), at(4)],
            velocity: [at(5), at(6)],
            stress: [at(7), at(8), at(9), at(10)],
            pore_pressure: at(11),
            deviator_strain: at(12),
            volume: at(13),
            mass: at(14),
        }
    }
}

impl Record for WaterParticle {
    const NAMES: &'static [&'static str] =
        &["x_m", "y_m", "velocity_x_m_per_s", "velocity_y_m_per_s", "pressure_pa", "volume_m3"];

    fn words(&self) -> Vec<u32> {
        let ([x, y], [vx, vy]) = (self.x, self.velocity);
        [x, y, vx, vy, self.pressure, self.volume].map(bits).to_vec()
    }

    fn from_words(words: &[u32]) -> Self {
        let at = |place: usize| number(words[place]);
        Self { x: [at(0), at(1)], velocity: [at(2), at(3)], pressure: at(4), volume: at(5) }
    }
}

impl Record for CellState {
    const NAMES: &'static [&'static str] = &["soil", "saturation", "pressure_pa"];

    fn words(&self) -> Vec<u32> {
        [self.soil, self.saturation, self.pressure].map(bits).to_vec()
    }

    fn from_words(words: &[u32]) -> Self {
        Self { soil: number(words[0]), saturation: number(words[1]), pressure: number(words[2]) }
    }
}
