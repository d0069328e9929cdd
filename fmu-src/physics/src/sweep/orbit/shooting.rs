//! Newton's method on the return map, and the multipliers of what it finds.

use super::super::Subject;
use super::return_map::{Return, ReturnMap};
use crate::error::PhysicsError;
use crate::integrate::State;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Steps after which Newton's method is given up.
const STEPS: usize = 25;
/// Halvings of a step that makes the residual larger.
const HALVINGS: usize = 6;
/// Difference for derivatives, as a share of the amplitude: the error of central differences and that of the runs are
/// both about 1e-9 of the derivative then.
const DIFFERENCE: f64 = 2e-5;
/// Residual, as a share of the amplitude, at which a motion counts as periodic.
const CLOSED: f64 = 1e-11;

/// Why no periodic motion was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrbitError {
    /// The model can't be run.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// The section is not met again.
    #[error(
        "no peak within {time} s: the motion dies out or sticks; start from a motion that vibrates"
    )]
    NoReturn {
        /// Time waited in s.
        time: f64,
    },
    /// Newton's method does not come to rest.
    #[error("Newton's method ends {residual} m away from a periodic motion; start nearer to one")]
    NotFound {
        /// Distance of the motion from itself one period later, in m.
        residual: f64,
    },
    /// The equations depend on time or on the place on the belt.
    #[error(
        "the model is driven in time or along the belt, so its motions are no fixed points of the return map; switch that effect off"
    )]
    Driven,
}

/// A periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    /// State at the peak.
    pub state: State,
    /// Tip displacement w at the peak, in m.
    pub displacement: f64,
    /// Period in s.
    pub period: f64,
    /// Half the distance from the lowest trough to the highest peak, in m.
    pub amplitude: f64,
    /// Share of time in stick.
    pub stick_fraction: f64,
    /// Modes entered during a period: `s` stick, `-` backward slip, `+` forward slip.
    pub sequence: String,
    /// Floquet multipliers without the trivial one, the largest first.
    pub multipliers: Vec<Complex<f64>>,
}

impl Orbit {
    /// Whether nearby motions come back to it: all multipliers within the unit circle.
    pub fn is_stable(&self) -> bool {
        self.largest() < 1.0
    }

    /// Magnitude of the largest multiplier.
    pub fn largest(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |m| m.norm())
    }
}

/// Finds the periodic motion of `returns` peaks per period near a state at a peak.
///
/// # Errors
/// [`OrbitError`].
pub fn shoot(subject: &Subject, guess: &State, returns: usize) -> Result<Orbit, OrbitError> {
    let mut map = ReturnMap::new(subject, returns)?;
    let mut y = map.coordinates(guess);
    let mut image = map.apply(&map.state(&y))?;
    let mut residual = map.coordinates(&image.state) - &y;
    for _ in 0..STEPS {
        let size = half(&image);
        if residual.norm() < CLOSED * size {
            break;
        }
        let slope = derivative(&mut map, &y, DIFFERENCE * size)?;
        let system = DMatrix::identity(map.count(), map.count()) - slope;
        let Some(step) = system.lu().solve(&residual) else {
            break;
        };
        let Some((next, its_image, its_residual)) = shortened(&mut map, &y, &step, residual.norm())
        else {
            break;
        };
        (y, image, residual) = (next, its_image, its_residual);
    }
    // Near the end rounding decides; a residual that is as small as that is as good as none.
    if residual.norm() > 100.0 * CLOSED * half(&image) {
        return Err(OrbitError::NotFound {
            residual: residual.norm(),
        });
    }
    orbit(&mut map, &y, &image)
}

/// Half the range of a return, in m.
pub(super) fn half(image: &Return) -> f64 {
    0.5 * (image.range.0 - image.range.1)
}

type Tried = (DVector<f64>, Return, DVector<f64>);

/// The step, or a part of it that makes the residual smaller.
fn shortened(
    map: &mut ReturnMap,
    y: &DVector<f64>,
    step: &DVector<f64>,
    size: f64,
) -> Option<Tried> {
    let mut share = 1.0;
    for _ in 0..HALVINGS {
        let next = y + share * step;
        if let Ok(image) = map.apply(&map.state(&next)) {
            let residual = map.coordinates(&image.state) - &next;
            if residual.norm() < size {
                return Some((next, image, residual));
            }
        }
        share *= 0.5;
    }
    None
}

/// Derivative of the map by central differences of `h` in m.
pub(super) fn derivative(
    map: &mut ReturnMap,
    y: &DVector<f64>,
    h: f64,
) -> Result<DMatrix<f64>, OrbitError> {
    let n = map.count();
    let mut slope = DMatrix::zeros(n, n);
    for i in 0..n {
        let mut at = |shift: f64| {
            let mut moved = y.clone();
            moved[i] += shift;
            let image = map.apply(&map.state(&moved))?;
            Ok::<_, OrbitError>(map.coordinates(&image.state))
        };
        let difference = at(h)? - at(-h)?;
        slope.set_column(i, &(difference / (2.0 * h)));
    }
    Ok(slope)
}

/// The orbit through coordinates `y` that are a fixed point.
pub(super) fn orbit(
    map: &mut ReturnMap,
    y: &DVector<f64>,
    image: &Return,
) -> Result<Orbit, OrbitError> {
    let slope = derivative(map, y, DIFFERENCE * half(image))?;
    let state = map.state(y);
    Ok(Orbit {
        displacement: map.displacement(&state),
        state,
        period: image.duration,
        amplitude: half(image),
        stick_fraction: image.stick,
        sequence: image.sequence.clone(),
        multipliers: eigenvalues(slope),
    })
}

/// Eigenvalues, the largest first.
fn eigenvalues(matrix: DMatrix<f64>) -> Vec<Complex<f64>> {
    let Some(schur) = Schur::try_new(matrix, 1e-14, 10_000) else {
        return Vec::new();
    };
    let mut all: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    all.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    all
}
