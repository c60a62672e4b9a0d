//! Principal stresses in order, and their transformation back to the components of a dimension.

/// Ordered principal stresses of a state, and what stands where among them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ordered {
    /// s1 >= s2 >= s3, Pa.
    pub values: [f64; 3],
    /// In plane strain the places among them of the larger and the smaller stress in the plane, and of zz; in a column
    /// those of the vertical stress and of the lateral ones.
    pub place: [usize; 3],
    /// cos and sin of twice the angle from x to the larger stress in the plane; in a column (1, 0).
    pub turn: [f64; 2],
}

/// Plane strain: two in the plane, and zz in any place among them.
pub(super) fn in_plane(&[xx, yy, zz, xy]: &[f64; 4]) -> Ordered {
    let (centre, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = (half * half + xy * xy).sqrt();
    let (high, low) = (centre + radius, centre - radius);
    // Where both are equal any direction will do, because the return keeps them equal.
    let turn = if radius > 0.0 { [half / radius, xy / radius] } else { [1.0, 0.0] };
    if zz > high {
        Ordered { values: [zz, high, low], place: [1, 2, 0], turn }
    } else if zz < low {
        Ordered { values: [high, low, zz], place: [0, 1, 2], turn }
    } else {
        Ordered { values: [high, zz, low], place: [0, 2, 1], turn }
    }
}

impl Ordered {
    /// The components of other principal stresses (Pa) in the same directions.
    pub fn with(&self, values: &[f64; 3]) -> [f64; 4] {
        let [high, low, zz] = self.place.map(|place| values[place]);
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let ([cos, sin], radius) = (self.turn, radius);
        [centre + radius * cos, centre - radius * cos, zz, radius * sin]
    }
}
