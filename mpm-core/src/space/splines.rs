//! B-splines of any degree on knots that may repeat.
//!
//! Source: Piegl & Tiller, *The NURBS Book*, 2nd ed. 1997, ch. 2; de Boor, *A Practical Guide to Splines*, 1978, ch. X.

/// Most functions that do not vanish at a point of an axis: those of degree 4.
pub const MOST_ALONG: usize = 5;

/// The functions that do not vanish at a point of an axis, and their derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// Number of the first function.
    pub first: usize,
    /// Values.
    pub value: [f64; MOST_ALONG],
    /// Derivatives, 1/m.
    pub slope: [f64; MOST_ALONG],
}

/// B-splines on open knots: the first and the last coefficient are the values at the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Splines {
    degree: usize,
    /// Knots, m; the ends `degree + 1` times.
    knots: Vec<f64>,
    /// Number of the last knot at the lower end of each cell.
    spans: Vec<usize>,
}

impl Splines {
    /// On cells between `lines` (m, ascending), the inner ones of which are knots so many `times`: functions of degree p have
    /// p - m continuous derivatives at a knot that is there m times.
    pub fn new(lines: &[f64], degree: usize, times: impl Fn(usize) -> usize) -> Self {
        let last = lines.len() - 1;
        let (mut knots, mut spans) = (vec![lines[0]; degree + 1], vec![degree]);
        for line in 1..last {
            knots.extend(std::iter::repeat_n(lines[line], times(line)));
            spans.push(knots.len() - 1);
        }
        knots.extend(std::iter::repeat_n(lines[last], degree + 1));
        Self { degree, knots, spans }
    }

    /// Functions.
    pub fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Functions that do not vanish in a cell.
    pub fn support(&self) -> usize {
        self.degree + 1
    }

    /// First function of a cell.
    pub fn first(&self, cell: usize) -> usize {
        self.spans[cell] - self.degree
    }

    /// Cell with a first function.
    pub fn cell_with(&self, first: usize) -> usize {
        self.spans.partition_point(|span| *span < first + self.degree)
    }

    /// The functions of a cell at a point (m), which may lie a little beyond it (algorithm A2.2).
    #[inline]
    pub fn at(&self, cell: usize, x: f64) -> Local {
        let span = self.spans[cell];
        let mut local = Local { first: span - self.degree, value: [0.0; MOST_ALONG], slope: [0.0; MOST_ALONG] };
        local.value[0] = 1.0;
        for degree in 1..=self.degree {
            let mut saved = 0.0;
            for r in 0..degree {
                let (below, above) = (self.knots[span + r + 1 - degree], self.knots[span + r + 1]);
                let share = local.value[r] / (above - below);
                local.value[r] = saved + (above - x) * share;
                saved = (x - below) * share;
                if degree == self.degree {
                    local.slope[r] -= share * degree as f64;
                    local.slope[r + 1] += share * degree as f64;
                }
            }
            local.value[degree] = saved;
        }
        local
    }

    /// The derivatives of the highest order that is not zero, the degree: constant in a cell, 1/m^degree.
    pub fn highest(&self, cell: usize) -> [f64; MOST_ALONG] {
        let span = self.spans[cell];
        let mut of = [0.0; MOST_ALONG];
        of[0] = 1.0;
        for degree in 1..=self.degree {
            // N' = p (N_below/(its support) - N_above/(its support)), de Boor's (X.12).
            let mut saved = 0.0;
            for r in 0..degree {
                let share = degree as f64 * of[r] / (self.knots[span + r + 1] - self.knots[span + r + 1 - degree]);
                of[r] = saved - share;
                saved = share;
            }
            of[degree] = saved;
        }
        of
    }

    /// Where a function stands, m: coefficients there make `sum_i N_i x_i = x` (Greville).
    pub fn stands(&self, function: usize) -> f64 {
        self.knots[function + 1..=function + self.degree].iter().sum::<f64>() / self.degree as f64
    }

    /// Where to sample a field for the coefficient of a function (m), and with which weights: exact for polynomials of the degree
    /// (de Boor 2001, A Practical Guide to Splines, ch. XII: the blossom of the polynomial through the samples).
    pub fn samples(&self, function: usize) -> Vec<(f64, f64)> {
        let knots = &self.knots[function + 1..=function + self.degree];
        let (low, high) = (knots[0], knots[self.degree - 1]);
        if low == high {
            return vec![(low, 1.0)];
        }
        let places: Vec<f64> = (0..=self.degree).map(|i| low + (high - low) * i as f64 / self.degree as f64).collect();
        let weight = |at: usize| {
            let others = || places.iter().enumerate().filter(move |(i, _)| *i != at).map(|(_, x)| *x);
            blossom(&others().collect::<Vec<_>>(), knots) / others().map(|x| places[at] - x).product::<f64>()
        };
        (0..places.len()).map(|i| (places[i], weight(i))).collect()
    }

    /// Integral of a function, m.
    pub fn integral(&self, function: usize) -> f64 {
        (self.knots[function + self.degree + 1] - self.knots[function]) / (self.degree + 1) as f64
    }
}
/// The mean of `(t_1 - x_1) ... (t_p - x_p)` over all orders of the arguments t: the polynomial of the roots x where all t are one.
fn blossom(roots: &[f64], arguments: &[f64]) -> f64 {
    let Some((root, others)) = roots.split_first() else { return 1.0 };
    let without = |i: usize| [&arguments[..i], &arguments[i + 1..]].concat();
    let sum: f64 = (0..arguments.len()).map(|i| (arguments[i] - root) * blossom(others, &without(i))).sum();
    sum / arguments.len() as f64
}
