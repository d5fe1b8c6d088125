//! How much a residual counts: by its square, or by less where it is large, so that a wrong measurement spoils little.

/// A loss `rho(r^2)` of a residual `r` in units of its standard deviation; the cost is half the sum of all.
///
/// ```
/// use mrroc_calibration::Loss;
///
/// assert_eq!(Loss::Squares.of(3.0), 9.0);
/// assert_eq!(Loss::Huber(1.0).of(3.0), 5.0); // 2 * 3 - 1
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// `r^2`: measurements whose errors are normally distributed.
    Squares,
    /// Huber's: `r^2` up to this many standard deviations (> 0), linear beyond.
    Huber(f64),
    /// Cauchy's: `c^2 ln(1 + r^2 / c^2)`, c > 0: what is far off hardly counts.
    Cauchy(f64),
}

impl Loss {
    /// The loss of one residual.
    #[must_use]
    pub fn of(self, r: f64) -> f64 {
        match self {
            Loss::Squares => r * r,
            Loss::Huber(c) if r.abs() <= c => r * r,
            Loss::Huber(c) => 2.0 * c * r.abs() - c * c,
            Loss::Cauchy(c) => c * c * (r * r / (c * c)).ln_1p(),
        }
    }

    /// `d rho / d r^2`: the weight of the residual's square near `r`, 0 to 1.
    #[must_use]
    pub fn weight(self, r: f64) -> f64 {
        match self {
            Loss::Squares => 1.0,
            Loss::Huber(c) => (c / r.abs()).min(1.0),
            Loss::Cauchy(c) => 1.0 / (1.0 + r * r / (c * c)),
        }
    }

    /// Half the sum of the losses.
    #[must_use]
    pub fn cost(self, residuals: &[f64]) -> f64 {
        0.5 * residuals.iter().map(|r| self.of(*r)).sum::<f64>()
    }
}
