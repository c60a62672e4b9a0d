//! Principal stresses in order, and their transformation back to components.

use crate::real::Real;

/// Ordered principal stresses of a state, and what stands where among them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ordered<R = f64> {
    /// s1 >= s2 >= s3, Pa.
    pub values: [R; 3],
    /// The larger and the smaller stress in the plane, and zz, Pa.
    plane: [R; 3],
    /// cos and sin of twice the angle from x to the larger stress in the plane.
    turn: [R; 2],
}

impl<R: Real> Ordered<R> {
    /// Two in the plane, and zz in any place among them.
    #[inline(always)]
    pub fn of(&[xx, yy, zz, xy]: &[R; 4]) -> Self {
        let (centre, half) = ((xx + yy) * 0.5, (xx - yy) * 0.5);
        let radius = (half * half + xy * xy).root();
        let (high, low, none) = (centre + radius, centre - radius, xx.like(0.0));
        // Where both are equal any direction will do, because the return keeps them equal.
        let by = none.if_below(radius, radius, xx.like(1.0));
        let turn = [none.if_below(radius, half / by, xx.like(1.0)), none.if_below(radius, xy / by, none)];
        let values = [high.larger(zz), high.if_below(zz, high, zz.if_below(low, low, zz)), low.smaller(zz)];
        Self { values, plane: [high, low, zz], turn }
    }

    /// The components of other principal stresses (Pa) in the same directions.
    #[inline(always)]
    pub fn with(&self, &[s1, s2, s3]: &[R; 3]) -> [R; 4] {
        let [high, low, zz] = self.plane;
        let of_high = high.if_below(zz, s2, s1);
        let of_low = zz.if_below(low, s2, s3);
        let of_zz = high.if_below(zz, s1, zz.if_below(low, s3, s2));
        let (centre, radius, [cos, sin]) = ((of_high + of_low) * 0.5, (of_high - of_low) * 0.5, self.turn);
        [centre + radius * cos, centre - radius * cos, of_zz, radius * sin]
    }
}

impl Ordered {
    /// Places of the larger and the smaller stress in the plane and of zz among [`Self::values`]; cos and sin of twice the angle from x
    /// to the larger one in the plane.
    pub fn places(&self) -> ([usize; 3], [f64; 2]) {
        let [high, low, zz] = self.plane;
        let places = if zz > high {
            [1, 2, 0]
        } else if zz < low {
            [0, 1, 2]
        } else {
            [0, 2, 1]
        };
        (places, self.turn)
    }
}
