//! The likelihood of a segment: Gaussian while its error may be the noise's, with a bounded price where it is lost.
//!
//! With x = S/s^2, S the sum of squares of a segment's n residuals and s the sensor's noise, the negative logarithm of the
//! likelihood is
//!
//! ```text
//! l(x) = x/2                                  for x <= b,     b = n + 3 sqrt(2 n)
//! l(x) = b/2 + d/2 ln(1 + (x - b)/d)          beyond
//! ```
//!
//! up to constants that are the same for every model. b is the mean and three standard deviations of what noise alone
//! makes of x (chi-square with n degrees of freedom). What a model misses beyond that, because it grazed a transition or
//! lost the motion, is a free motion of the structure: it counts as a Student-t variable with as many degrees of freedom d
//! as the structure has states. So a lost segment costs some tens of nats whatever the model, and all models are compared on
//! the same samples. Source for the bounded form: Lange, Little and Taylor, JASA 84 (1989) 881, eq. 2.

/// Standard deviations of the noise's sum of squares beyond which a segment is lost.
const SURE: f64 = 3.0;

/// The likelihood of one segment.
#[derive(Debug, Clone, Copy)]
pub struct Likelihood {
    /// Variance of the noise, m^2.
    variance: f64,
    /// Largest x that may be noise alone.
    bound: f64,
    /// Degrees of freedom beyond.
    freedom: f64,
}

impl Likelihood {
    /// For `count` samples with noise of standard deviation `noise` in m, and a structure with `states` states.
    pub fn new(count: f64, noise: f64, states: usize) -> Self {
        Self {
            variance: noise * noise,
            bound: count + SURE * (2.0 * count).sqrt(),
            freedom: states as f64,
        }
    }

    /// Whether a sum of squares in m^2 is more than noise alone may have made.
    pub fn is_lost(self, sum: f64) -> bool {
        !(sum / self.variance <= self.bound)
    }

    /// Negative logarithm, in nats, at a sum of squares in m^2.
    pub fn loss(self, sum: f64) -> f64 {
        let x = sum / self.variance;
        if x <= self.bound {
            0.5 * x
        } else {
            let beyond = (x - self.bound) / self.freedom;
            0.5 * self.bound + 0.5 * self.freedom * beyond.ln_1p()
        }
    }

    /// Weight of the squares in the equivalent least squares, 1/m^2: twice the derivative of the loss.
    pub fn weight(self, sum: f64) -> f64 {
        let x = sum / self.variance;
        let beyond = ((x - self.bound) / self.freedom).max(0.0);
        1.0 / (self.variance * (1.0 + beyond))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_gaussian_where_noise_may_have_made_it_and_grows_with_a_logarithm_beyond() {
        let l = Likelihood::new(100.0, 2.0, 4);
        assert!((l.loss(400.0) - 50.0).abs() < 1e-12);
        let ten_times = l.loss(4e7) - l.loss(4e6);
        assert!(
            (ten_times - 2.0 * 10.0_f64.ln()).abs() < 1e-3,
            "{ten_times}"
        );
    }

    #[test]
    fn the_weight_is_twice_the_derivative_of_the_loss() {
        let l = Likelihood::new(50.0, 1e-6, 6);
        for sum in [1e-11, 7e-11, 9e-11, 1e-9, 1e-6] {
            let h = 1e-5 * sum;
            let slope = (l.loss(sum + h) - l.loss(sum - h)) / (2.0 * h);
            assert!((2.0 * slope / l.weight(sum) - 1.0).abs() < 1e-4, "{sum}");
        }
    }
}
