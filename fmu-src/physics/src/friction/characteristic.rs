//! The friction laws that are made of two exponentials, as forces over the sliding speed.

use super::FrictionLaw;
use crate::integrate::collocation::Characteristic;

impl FrictionLaw {
    /// The force `load mu(u)` in N, for a load (level times normal force) in N; `None` for laws that are not sums of exponentials:
    /// tables, eq. (7) as printed, other exponents than 1 and 2.
    pub fn characteristic(&self, load: f64) -> Option<Characteristic> {
        let sum = self.exponential_sum()?;
        let ([first, second, product, _], [fast, slow, ..]) = (sum.weight, sum.rate);
        Some(Characteristic {
            constant: load * sum.constant,
            linear: load * sum.linear,
            weight: [load * first, load * second, load * product],
            rate: [fast, slow],
            squared: sum.squared,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::friction::FrictionLaw;
    use crate::friction::series::tests::laws;
    use approx::assert_relative_eq;

    #[test]
    fn val_the_characteristic_is_the_law_times_the_load() {
        // Source: FrictionLaw::coefficient.
        for law in laws() {
            let characteristic = law.characteristic(80.0).unwrap();
            let speeds = std::array::from_fn(|i| 0.013 * i as f64);
            let (force, ..) = characteristic.at(&speeds);
            for (u, p) in speeds.iter().zip(force) {
                assert_relative_eq!(p, 80.0 * law.coefficient(*u), max_relative = 1e-14);
            }
        }
        let stribeck = FrictionLaw::Stribeck {
            mu_s: 0.66,
            mu_k: 0.3,
            velocity: 0.03,
            exponent: 1.5,
            viscous: 0.2,
        };
        assert!(stribeck.characteristic(1.0).is_none());
    }
}
