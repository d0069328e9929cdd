//! The friction laws that are made of two exponentials, as forces over the sliding speed.

use super::FrictionLaw;
use crate::integrate::collocation::Characteristic;

impl FrictionLaw {
    /// The force `load mu(u)` in N, for a load (level times normal force) in N; `None` for laws that are not made of at most two
    /// exponentials: tables, eq. (7) as printed, other exponents than 1 and 2.
    pub fn characteristic(&self, load: f64) -> Option<Characteristic> {
        let none = Characteristic {
            constant: 0.0,
            linear: 0.0,
            weight: [0.0; 3],
            rate: [0.0; 2],
            squared: false,
        };
        Some(match self {
            Self::Stelter(p) => {
                let (mu, a, b) = (load * p.mu_0, 1.0 - p.a1, 1.0 - p.a2);
                Characteristic {
                    constant: mu * a * b,
                    weight: [mu * p.a1 * b, mu * a * p.a2, mu * p.a1 * p.a2],
                    rate: [1.0 / p.v1, p.c2],
                    ..none
                }
            }
            Self::Coulomb { mu_k, .. } => Characteristic {
                constant: load * mu_k,
                ..none
            },
            Self::Stribeck {
                mu_s,
                mu_k,
                velocity,
                exponent,
                viscous,
            } if *exponent == 1.0 || *exponent == 2.0 => Characteristic {
                constant: load * mu_k,
                linear: load * viscous,
                weight: [load * (mu_s - mu_k), 0.0, 0.0],
                rate: [velocity.powf(-exponent), 0.0],
                squared: *exponent == 2.0,
            },
            Self::Stribeck { .. } | Self::StelterAsPrinted(_) | Self::Table(_) => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::friction::{Exponential, FrictionLaw};
    use approx::assert_relative_eq;

    #[test]
    fn val_the_characteristic_is_the_law_times_the_load() {
        // Source: FrictionLaw::coefficient.
        let stribeck = |exponent| FrictionLaw::Stribeck {
            mu_s: 0.66,
            mu_k: 0.3,
            velocity: 0.03,
            exponent,
            viscous: 0.2,
        };
        let laws = [
            FrictionLaw::Stelter(Exponential::default()),
            FrictionLaw::Coulomb {
                mu_s: 0.6,
                mu_k: 0.4,
            },
            stribeck(1.0),
            stribeck(2.0),
        ];
        for law in laws {
            let characteristic = law.characteristic(80.0).unwrap();
            let speeds = std::array::from_fn(|i| 0.013 * i as f64);
            let (force, _) = characteristic.at(&speeds);
            for (u, p) in speeds.iter().zip(force) {
                assert_relative_eq!(p, 80.0 * law.coefficient(*u), max_relative = 1e-14);
            }
        }
        assert!(stribeck(1.5).characteristic(1.0).is_none());
    }
}
