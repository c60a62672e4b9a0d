//! The return in ordered principal stresses: which part of the surface, and where on it.

use super::surface::{Soil, Surface};
use crate::real::Real;

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

impl Region {
    /// All of them, in the order of their numbers.
    const ALL: [Self; 11] = [
        Self::Elastic,
        Self::Face,
        Self::CompressionEdge,
        Self::ExtensionEdge,
        Self::Apex,
        Self::Tension,
        Self::TensionEdge,
        Self::TensionCorner,
        Self::Seam,
        Self::CompressionEnd,
        Self::ExtensionEnd,
    ];

    /// As a number among stresses.
    #[inline(always)]
    fn number<R: Real>(self, like: R) -> R {
        like.like(f64::from(self as u8))
    }
}

impl Surface {
    /// The part of the surface that a trial stress ends on, and the stress there, both ordered, Pa.
    pub fn back(&self, trial: &[f64; 3]) -> (Region, [f64; 3]) {
        let [found @ .., region] = self.returned(trial);
        (Region::ALL[region as usize], found)
    }
}

impl<R: Real> Surface<R> {
    /// The stress on or inside the surface that a trial stress is brought back to, both ordered, Pa; and the number of the region.
    ///
    /// The return is the one whose multipliers are all non-negative and which no plane is violated by. A return to the
    /// Mohr-Coulomb planes alone that keeps below the cut-off is it, and so is one to the cut-off alone that keeps f <= 0;
    /// if neither is, planes of both kinds are active, and those meet on a line and its two ends.
    #[inline(always)]
    pub fn returned(&self, trial: &[R; 3]) -> [R; 4] {
        let [s1, s2, s3] = *trial;
        let (over, none) = (self.over(s1, s3), s1.like(0.0));
        let (sheared, same) = (self.sheared(trial, over), [s1, s2, s3, Region::Elastic.number(s1)]);
        let found = none.if_below_all(over, &sheared, &same);
        if self.soil.cutoff == f64::INFINITY {
            return found;
        }
        let (torn, seam) = (self.torn(trial), self.on_seam(trial));
        let torn = torn[2].if_below_all(self.low, &seam, &torn);
        // Inside, and so on the planes of f alone, the largest stress is that which may be beyond the cut-off.
        s1.like(self.soil.cutoff).if_below_all(found[0], &torn, &found)
    }

    /// Return to the planes of f alone (de Souza Neto et al. 2008, boxes 8.4 to 8.7); `over` is f of the trial stress.
    #[inline(always)]
    fn sheared(&self, &[s1, s2, s3]: &[R; 3], over: R) -> [R; 4] {
        let (push, gamma) = (&self.push, over * self.of_face);
        let face = [s1 - gamma * push[0], s2 - gamma * push[1], s3 - gamma * push[2], Region::Face.number(s1)];
        // On an edge two planes are active with multipliers a and b; only a + b enters, as the two stresses are equal.
        let gamma = (over + self.over(s2, s3)) * self.of_edge[0];
        let (high, low) = ((s1 + s2 - gamma * (push[0] + push[1])) * 0.5, s3 - gamma * push[2]);
        let compression = [high, high, low, Region::CompressionEdge.number(s1)];
        let gamma = (over + self.over(s1, s2)) * self.of_edge[1];
        let (high, low) = (s1 - gamma * push[0], (s2 + s3 - gamma * (push[1] + push[2])) * 0.5);
        let extension = [high, low, low, Region::ExtensionEdge.number(s1)];
        // With psi = 0 no flow can lower the mean stress to that of the apex: it is put there all the same.
        let apex = s1.like(self.soil.apex);
        let apex = [apex, apex, apex, Region::Apex.number(s1)];
        let compression_or_apex = compression[0].if_below_all(compression[2], &apex, &compression);
        let extension_or_apex = extension[0].if_below_all(extension[2], &apex, &extension);
        // Above and below at once: the edge that there is.
        let either = compression[0].if_below_all(compression[2], &extension_or_apex, &compression);
        let above = face[1].if_below_all(face[2], &either, &compression_or_apex);
        let beside = face[1].if_below_all(face[2], &extension_or_apex, &face);
        face[0].if_below_all(face[1], &above, &beside)
    }

    /// Return to the cut-off alone: the nearest stress (in energy) with all s_i <= sigma_t. A unit of strain along s_i
    /// takes lambda + 2 G from s_i and lambda from the others.
    #[inline(always)]
    fn torn(&self, &[s1, s2, s3]: &[R; 3]) -> [R; 4] {
        let Soil { lame, shear, cutoff, .. } = self.soil;
        let most = s1.like(cutoff);
        let aside = (s1 - most) * lame / s1.like(lame + 2.0 * shear);
        let one = [most, s2 - aside, s3 - aside, Region::Tension.number(s1)];
        let aside = (s1 + s2 - most * 2.0) * lame / s1.like(2.0 * (lame + shear));
        let two = [most, most, s3 - aside, Region::TensionEdge.number(s1)];
        let all = [most, most, most, Region::TensionCorner.number(s1)];
        most.if_below_all(one[1], &most.if_below_all(two[2], &all, &two), &one)
    }

    /// Return to where f = 0 meets s1 = sigma_t. Nothing flows along s2 on the line, so there
    /// s2 - nu (s1 + s3) = E eps_2 is that of the trial stress, whatever the flow rule; beyond its ends s2 is s1 or s3.
    #[inline(always)]
    fn on_seam(&self, &[s1, s2, s3]: &[R; 3]) -> [R; 4] {
        let (high, low) = (s1.like(self.soil.cutoff), self.low);
        let middle = s2 - (s1 - high + s3 - low) * self.soil.poisson_ratio;
        let seam = [high, middle, low, Region::Seam.number(s1)];
        let lower = [high, low, low, Region::ExtensionEnd.number(s1)];
        let upper = [high, high, low, Region::CompressionEnd.number(s1)];
        middle.if_below_all(high, &low.if_below_all(middle, &seam, &lower), &upper)
    }
}
