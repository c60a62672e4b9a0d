//! The return in ordered principal stresses: which part of the surface, and where on it.

use super::surface::Surface;

/// Parts of the surface in ordered principal stresses s1 >= s2 >= s3. The first five are numbered as in the tables of
/// `reference-data/exact`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Region {
    /// Inside.
    Elastic = 0,
    /// f = 0.
    Face = 1,
    /// f = 0 where s1 = s2 (triaxial compression).
    CompressionEdge = 2,
    /// f = 0 where s2 = s3 (triaxial extension).
    ExtensionEdge = 3,
    /// All equal to c/tan(phi).
    Apex = 4,
    /// s1 = sigma_t.
    Tension = 5,
    /// s1 = s2 = sigma_t.
    TensionEdge = 6,
    /// All equal to sigma_t.
    TensionCorner = 7,
    /// f = 0 and s1 = sigma_t.
    Seam = 8,
    /// The same where s1 = s2.
    CompressionEnd = 9,
    /// The same where s2 = s3.
    ExtensionEnd = 10,
}

impl Surface {
    /// The stress on or inside the surface that a trial stress is brought back to, both ordered, Pa.
    ///
    /// The return is the one whose multipliers are all non-negative and which no plane is violated by. A return to the
    /// Mohr-Coulomb planes alone that keeps below the cut-off is it, and so is one to the cut-off alone that keeps f <= 0;
    /// if neither is, planes of both kinds are active, and those meet on a line and its two ends.
    #[inline]
    pub fn back(&self, trial: &[f64; 3]) -> (Region, [f64; 3]) {
        let over = self.over(trial[0], trial[2]);
        if over > 0.0 {
            let found = self.sheared(trial, over);
            if found.1[0] <= self.cutoff {
                return found;
            }
        } else if trial[0] <= self.cutoff {
            return (Region::Elastic, *trial);
        }
        let found = self.torn(trial);
        if found.1[2] >= self.low { found } else { self.on_seam(trial) }
    }

    /// Return to the planes of f alone (de Souza Neto et al. 2008, boxes 8.4 to 8.7); `over` is f of the trial stress.
    fn sheared(&self, &[s1, s2, s3]: &[f64; 3], over: f64) -> (Region, [f64; 3]) {
        let (push, gamma) = (&self.push, over * self.of_face);
        let face = [s1 - gamma * push[0], s2 - gamma * push[1], s3 - gamma * push[2]];
        let (above, below) = (face[1] > face[0], face[1] < face[2]);
        if !above && !below {
            return (Region::Face, face);
        }
        // On an edge two planes are active with multipliers a and b; only a + b enters, as the two stresses are equal.
        if above {
            let gamma = (over + self.over(s2, s3)) * self.of_edge[0];
            let (high, low) = (0.5 * (s1 + s2 - gamma * (push[0] + push[1])), s3 - gamma * push[2]);
            if high >= low {
                return (Region::CompressionEdge, [high, high, low]);
            }
        }
        if below {
            let gamma = (over + self.over(s1, s2)) * self.of_edge[1];
            let (high, low) = (s1 - gamma * push[0], 0.5 * (s2 + s3 - gamma * (push[1] + push[2])));
            if high >= low {
                return (Region::ExtensionEdge, [high, low, low]);
            }
        }
        // With psi = 0 no flow can lower the mean stress to that of the apex: it is put there all the same.
        (Region::Apex, [self.apex; 3])
    }

    /// Return to the cut-off alone: the nearest stress (in energy) with all s_i <= sigma_t. A unit of strain along s_i
    /// takes lambda + 2 G from s_i and lambda from the others.
    fn torn(&self, &[s1, s2, s3]: &[f64; 3]) -> (Region, [f64; 3]) {
        let most = self.cutoff;
        let aside = self.lame * (s1 - most) / (self.lame + 2.0 * self.shear);
        if s2 - aside <= most {
            return (Region::Tension, [most, s2 - aside, s3 - aside]);
        }
        let aside = self.lame * (s1 + s2 - 2.0 * most) / (2.0 * (self.lame + self.shear));
        if s3 - aside <= most {
            return (Region::TensionEdge, [most, most, s3 - aside]);
        }
        (Region::TensionCorner, [most; 3])
    }

    /// Return to where f = 0 meets s1 = sigma_t. Nothing flows along s2 on the line, so there
    /// s2 - nu (s1 + s3) = E eps_2 is that of the trial stress, whatever the flow rule; beyond its ends s2 is s1 or s3.
    fn on_seam(&self, &[s1, s2, s3]: &[f64; 3]) -> (Region, [f64; 3]) {
        let (high, low) = (self.cutoff, self.low);
        let middle = s2 - self.poisson_ratio * (s1 - high + s3 - low);
        if middle >= high {
            (Region::CompressionEnd, [high, high, low])
        } else if middle <= low {
            (Region::ExtensionEnd, [high, low, low])
        } else {
            (Region::Seam, [high, middle, low])
        }
    }
}
