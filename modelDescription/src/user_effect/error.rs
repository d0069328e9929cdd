//! What can be wrong with a user's effect.

/// What is wrong with a user's effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UserEffectError {
    /// Not TOML, an unknown or missing key, or a value of the wrong type.
    #[error("{problem}")]
    File {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// An id that can't be used.
    #[error("id = '{id}' can't be used: {problem}; choose another")]
    Id {
        /// Line, counted from 1.
        line: usize,
        /// The id.
        id: String,
        /// Why not.
        problem: &'static str,
    },
    /// A text that is not one of a list.
    #[error("{key} = '{found}' is unknown; write {known}")]
    Choice {
        /// Line, counted from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// The text found.
        found: String,
        /// What is known.
        known: String,
    },
    /// A text that is empty, too long or has characters that can't be shown.
    #[error(
        "{key} is empty, longer than {most} characters or has control characters; shorten or correct it"
    )]
    Text {
        /// Line, counted from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// Most characters.
        most: usize,
    },
    /// A number of a parameter that can't be.
    #[error("parameter '{name}': {key} = {value} {unit} is not possible; it must be {required}")]
    Value {
        /// Line, counted from 1.
        line: usize,
        /// Name of the parameter.
        name: String,
        /// The key.
        key: &'static str,
        /// The value.
        value: f64,
        /// Unit of the parameter.
        unit: String,
        /// The condition in words.
        required: &'static str,
    },
    /// Too many parameters.
    #[error("{count} parameters; at most {max} are possible, write constants as numbers")]
    Parameters {
        /// Line of the first one too many, counted from 1.
        line: usize,
        /// Number of parameters.
        count: usize,
        /// The largest number.
        max: usize,
    },
    /// No parameter switches the effect on.
    #[error(
        "no [[parameter]] has role = \"amplitude\"; one must, since the effect is off where all amplitudes are 0"
    )]
    NoAmplitude {
        /// Line of the formula, counted from 1.
        line: usize,
    },
    /// The formula or its names can't be used.
    #[error("{problem}; correct the expression or the parameters")]
    Expression {
        /// Line of the formula, counted from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// Units that do not fit together.
    #[error("{key}: {problem}; correct the formula or the units")]
    Units {
        /// Line of the formula, counted from 1.
        line: usize,
        /// Whose formula it is.
        key: String,
        /// What does not fit.
        problem: String,
    },
    /// The formula does something although the effect is off.
    #[error(
        "with all amplitudes 0 the expression gives {value} instead of {neutral}, so the effect would never be off; \
         multiply by an amplitude what acts, for example {example}"
    )]
    NeverOff {
        /// Line of the formula, counted from 1.
        line: usize,
        /// Value of the formula.
        value: f64,
        /// Value that means no effect.
        neutral: f64,
        /// A formula that can be off.
        example: &'static str,
    },
    /// Two effects with the same id.
    #[error("two effects have the id '{id}'; rename one")]
    Twice {
        /// The id.
        id: String,
    },
    /// Too many effects.
    #[error("{count} effects of one's own; at most {max} are possible in one FMU")]
    TooMany {
        /// Number of effects.
        count: usize,
        /// The largest number.
        max: usize,
    },
}

impl UserEffectError {
    /// Line of the file, counted from 1, where one is to blame.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::File { line, .. }
            | Self::Id { line, .. }
            | Self::Choice { line, .. }
            | Self::Text { line, .. }
            | Self::Value { line, .. }
            | Self::Parameters { line, .. }
            | Self::NoAmplitude { line }
            | Self::Expression { line, .. }
            | Self::Units { line, .. }
            | Self::NeverOff { line, .. } => Some(*line),
            Self::Twice { .. } | Self::TooMany { .. } => None,
        }
    }
}
