//! A damped oscillator in closed form.

/// `q'' + 2 D w q' + w^2 q = g F`, seen as `phi q'`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// Angular frequency w in rad/s, positive.
    pub frequency: f64,
    /// Damping ratio D, at least 0 and below 1.
    pub damping: f64,
    /// Share phi of its velocity in what is seen.
    pub seen: f64,
    /// Acceleration g per force in 1/kg.
    pub gain: f64,
}

impl Oscillator {
    /// The free motion after time `t` in s: q and q' from unit displacement, and from unit velocity.
    ///
    /// `exp(-D w t)` times `cos + (D w/w_d) sin` and `-(w^2/w_d) sin`, and times `sin/w_d` and `cos - (D w/w_d) sin`, of
    /// the angle `w_d t` with `w_d = w sqrt(1 - D^2)`.
    pub fn free(&self, t: f64) -> [[f64; 2]; 2] {
        let decay = self.damping * self.frequency;
        let own = self.frequency * (1.0 - self.damping * self.damping).sqrt();
        let (sin, cos) = (own * t).sin_cos();
        let size = (-decay * t).exp();
        let (part, swing) = (decay / own * sin, sin / own);
        let square = self.frequency * self.frequency;
        [
            [size * (cos + part), -size * square * swing],
            [size * swing, size * (cos - part)],
        ]
    }
}
