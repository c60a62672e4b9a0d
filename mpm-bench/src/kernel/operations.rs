//! Arithmetic of a step, counted by hand from the formulas of `mpm_core::step::kernel`: the
//! paper's shape functions at the centre of the cell, with water or without, no gravity.
//!
//! What is the same for all particles of a cell (gradient, strain, spin, increments of stress and pressure) is counted
//! once per cell, what is written twice once, and a face once though two cells share it. A change of sign, the lesser of
//! two and a choice count nothing. A test runs the formulas of [`mpm_core::dimension`] with numbers that count.

/// Multiplications, additions (and subtractions), divisions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Operations {
    /// Multiplications.
    pub multiply: u32,
    /// Additions and subtractions.
    pub add: u32,
    /// Divisions.
    pub divide: u32,
}

/// What a part is done for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// Each solid particle.
    Solid,
    /// Each water particle.
    Water,
    /// Each cell.
    Cell,
    /// Each node; there are as many as cells but for the edges.
    Node,
}

/// Part, what it is done for, multiplications, additions, divisions, and whether only soil with water has it.
pub type Part = (&'static str, Of, u32, u32, u32, bool);

/// All parts of a step.
pub const PARTS: [Part; 38] = [
    ("place in the cell, before and after", Of::Solid, 4, 4, 0, false),
    ("basis", Of::Solid, 1, 0, 0, false),
    ("stress turned by the spin", Of::Solid, 2, 4, 0, false),
    ("increment of stress", Of::Solid, 0, 4, 0, false),
    ("volume", Of::Solid, 1, 0, 0, false),
    ("velocity and its change at the particle", Of::Solid, 12, 12, 0, false),
    ("velocity (FLIP) and position", Of::Solid, 4, 4, 0, false),
    ("shares of the corners", Of::Solid, 3, 3, 0, false),
    ("mass and volume of the cell", Of::Solid, 0, 2, 0, false),
    ("mass and momentum of the corners", Of::Solid, 8, 12, 0, false),
    ("volume times stress", Of::Solid, 4, 4, 0, false),
    ("place in the cell, before and after", Of::Water, 4, 4, 0, true),
    ("basis", Of::Water, 1, 0, 0, true),
    ("velocity at the particle", Of::Water, 6, 6, 0, true),
    ("pressure and volume", Of::Water, 1, 1, 0, true),
    ("position", Of::Water, 2, 2, 0, true),
    ("shares of the corners", Of::Water, 3, 3, 0, true),
    ("mass of the corners", Of::Water, 0, 4, 0, true),
    ("volume and volume times pressure", Of::Water, 1, 2, 0, true),
    ("coefficients of velocity and its change", Of::Cell, 0, 16, 0, false),
    ("Darcy's law on two faces", Of::Cell, 12, 8, 0, true),
    ("v* and its work", Of::Cell, 8, 6, 0, true),
    ("gradient at the centre", Of::Cell, 6, 4, 0, false),
    ("spin and strain", Of::Cell, 6, 2, 0, false),
    ("elastic increment", Of::Cell, 4, 3, 0, false),
    ("volume factor", Of::Cell, 1, 2, 0, false),
    ("v_w = v_s + v*", Of::Cell, 0, 4, 0, true),
    ("rates of pressure and of water volume", Of::Cell, 9, 4, 0, true),
    ("pressure, porosity and their inverses", Of::Cell, 2, 1, 3, true),
    ("pressure acting on the soil", Of::Cell, 7, 6, 0, true),
    ("internal force", Of::Cell, 5, 2, 0, false),
    ("force of the corners", Of::Cell, 0, 6, 0, false),
    ("mixture mass of the corners", Of::Cell, 0, 4, 0, true),
    ("five sums to four nodes", Of::Cell, 0, 15, 0, false),
    ("mixture mass to four nodes", Of::Cell, 0, 3, 0, true),
    ("1/m of the mixture", Of::Node, 0, 0, 1, false),
    ("1/m of the solid", Of::Node, 0, 0, 1, true),
    ("acceleration, velocity and its change", Of::Node, 10, 4, 0, false),
];

/// All operations for one particle, cell or node, with water or without.
pub fn of(what: Of, water: bool) -> Operations {
    let parts = PARTS.iter().filter(|part| part.1 == what && (water || !part.5));
    parts.fold(Operations::default(), |sum, (_, _, multiply, add, divide, _)| Operations {
        multiply: sum.multiply + multiply,
        add: sum.add + add,
        divide: sum.divide + divide,
    })
}

/// Multiplications with additions, and divisions, per point-step, `ppc` points in a cell, with water or without.
pub fn per_point(ppc: usize, water: bool) -> [f64; 2] {
    let simple = |o: Operations| f64::from(o.multiply + o.add);
    let particles = [of(Of::Solid, water), of(Of::Water, water)];
    let lattice = [of(Of::Cell, water), of(Of::Node, water)];
    let sum = |count: fn(Operations) -> f64| {
        particles.map(count).iter().sum::<f64>() + lattice.map(count).iter().sum::<f64>() / ppc as f64
    };
    [sum(simple), sum(|o| f64::from(o.divide))]
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

    use mpm_core::dimension::{
        basis, coefficients, gradient, internal_force, rotate, shares, strain_increment, to_corners, trace, value,
    };
    use mpm_core::real::Real;

    use super::*;

    thread_local! {
        static COUNT: Cell<[u32; 2]> = const { Cell::new([0; 2]) };
    }

    fn note(which: usize) {
        let mut count = COUNT.get();
        count[which] += 1;
        COUNT.set(count);
    }

    /// A number that counts what is done with it.
    #[derive(Clone, Copy)]
    struct Counted(f64);

    macro_rules! counts {
        ($trait:ident, $method:ident, $which:expr) => {
            impl $trait for Counted {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    note($which);
                    Self(self.0.$method(other.0))
                }
            }
        };
    }
    counts!(Mul, mul, 0);
    counts!(Add, add, 1);
    counts!(Sub, sub, 1);

    impl Mul<f64> for Counted {
        type Output = Self;
        fn mul(self, factor: f64) -> Self {
            self * Self(factor)
        }
    }
    impl Div for Counted {
        type Output = Self;
        fn div(self, other: Self) -> Self {
            Self(self.0 / other.0)
        }
    }
    impl Neg for Counted {
        type Output = Self;
        fn neg(self) -> Self {
            Self(-self.0)
        }
    }
    impl AddAssign for Counted {
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }
    impl SubAssign for Counted {
        fn sub_assign(&mut self, other: Self) {
            *self = *self - other;
        }
    }
    impl Real for Counted {
        fn like(self, constant: f64) -> Self {
            Self(constant)
        }
        fn root(self) -> Self {
            Self(self.0.sqrt())
        }
        fn larger(self, other: Self) -> Self {
            Self(self.0.larger(other.0))
        }
        fn smaller(self, other: Self) -> Self {
            Self(self.0.smaller(other.0))
        }
        fn if_below(self, other: Self, first: Self, second: Self) -> Self {
            if self.0 < other.0 { first } else { second }
        }
    }

    /// Multiplications and additions of a formula as it is written.
    fn counted<T>(formula: impl FnOnce() -> T) -> [u32; 2] {
        COUNT.set([0; 2]);
        formula();
        COUNT.get()
    }

    fn table(name: &str, of: Of) -> [u32; 2] {
        let found = PARTS.iter().find(|p| p.0 == name && p.1 == of).expect("a part");
        [found.2, found.3]
    }

    #[test]
    fn hand_counts_are_those_of_the_formulas_without_what_is_written_twice() {
        let one = Counted(0.5);
        let (xi, field) = ([one; 2], [[one; 2]; 4]);
        let slope = [[one; 2]; 2];
        let twice = |[multiply, add]: [u32; 2]| [2 * multiply, 2 * add];
        for of in [Of::Solid, Of::Water] {
            assert_eq!(counted(|| basis(&xi)), table("basis", of));
            assert_eq!(counted(|| shares(one, &xi)), table("shares of the corners", of));
        }
        let at_point = counted(|| value::<2, 2, _>(&field, &[one; 4]));
        assert_eq!(at_point, table("velocity at the particle", Of::Water));
        assert_eq!(twice(at_point), table("velocity and its change at the particle", Of::Solid));
        // b - a of each component stands twice.
        let [none, add] = counted(|| coefficients::<2, 2, _>(&field));
        assert_eq!(twice([none, add - 2]), table("coefficients of velocity and its change", Of::Cell));
        // Half of the bilinear coefficient is the same in both columns.
        let [multiply, add] = counted(|| gradient(&field, &xi, 50.0));
        assert_eq!([multiply - 2, add], table("gradient at the centre", Of::Cell));
        // 2 spin xy stands twice as two products; the spin is the cell's, and so is the strain, which has no zz.
        let [multiply, add] = counted(|| rotate::<2, _>(&mut [one; 4], &slope, 0.1));
        let strain = counted(|| strain_increment::<2, _>(&slope, 0.1));
        let (turned, spin) = (table("stress turned by the spin", Of::Solid), table("spin and strain", Of::Cell));
        assert_eq!([multiply - 2 + strain[0], add + strain[1]], [turned[0] + spin[0], turned[1] + spin[1]]);
        let force = counted(|| internal_force::<2, _>(&[one; 4], &[[one; 4]; 2], 50.0));
        assert_eq!(force, table("internal force", Of::Cell));
        // eta - both stands twice, and the constant moment is zero.
        let [none, add] = counted(|| to_corners::<2, 2, _>(&field));
        assert_eq!([none, add - 4], table("force of the corners", Of::Cell));
        let [none, add] = counted(|| trace(&slope));
        assert_eq!([none + 1, add + 1], table("volume factor", Of::Cell));
    }

    #[test]
    fn counts_add_up() {
        let sums = [Of::Solid, Of::Water, Of::Cell, Of::Node].map(|what| of(what, true));
        let counts = sums.map(|o| (o.multiply, o.add, o.divide));
        assert_eq!(counts, [(39, 49, 0), (18, 22, 0), (60, 86, 3), (10, 4, 2)]);
        assert_eq!(per_point(4, true), [88.0 + 40.0 + (146.0 + 14.0) / 4.0, 5.0 / 4.0]);
        assert_eq!(per_point(4, false), [88.0 + (72.0 + 14.0) / 4.0, 1.0 / 4.0]);
    }
}
