//! What a channel may be in a run, and the names and units that say so.

use super::super::Measurand;
use super::super::unit::Quantity;
use super::{Channel, names};

/// What a channel is to be.
pub(super) struct Role {
    pub(super) words: &'static str,
    pub(super) quantity: Quantity,
    pub(super) unit: &'static str,
    pub(super) option: &'static str,
    /// Names that say so, in lower case, letters and digits alone.
    pub(super) names: &'static [&'static str],
}

pub(super) const TIME: Role = Role {
    words: "the time",
    quantity: Quantity::Time,
    unit: "s",
    option: "--time",
    names: &[
        "time",
        "times",
        "t",
        "zeit",
        "timestamp",
        "timems",
        "timeus",
        "tms",
        "ts",
    ],
};

pub(super) const DISPLACEMENT: Role = Role {
    words: "the displacement",
    quantity: Quantity::Length,
    unit: "m",
    option: "--displacement",
    names: &[
        "tipdisplacementm",
        "tipdisplacement",
        "displacement",
        "displacementm",
        "disp",
        "x",
        "w",
        "xm",
        "wm",
        "deflection",
        "position",
        "laser",
        "weg",
    ],
};

/// Found by name alone: the belt has a velocity too.
pub(super) const VELOCITY: Role = Role {
    words: "the velocity",
    quantity: Quantity::Velocity,
    unit: "m/s",
    option: "--velocity",
    names: &[],
};

/// Found by name alone, as a velocity.
pub(super) const ACCELERATION: Role = Role {
    words: "the acceleration",
    quantity: Quantity::Acceleration,
    unit: "m/s^2",
    option: "--acceleration",
    names: &[],
};

pub(super) const BELT_VELOCITY: Role = Role {
    words: "the belt velocity",
    quantity: Quantity::Velocity,
    unit: "m/s",
    option: "--belt-velocity",
    names: &[
        "beltvelocitympers",
        "beltvelocity",
        "beltspeed",
        "vbelt",
        "vb",
        "v0",
        "belt",
    ],
};

pub(super) const NORMAL_FORCE: Role = Role {
    words: "the normal force",
    quantity: Quantity::Force,
    unit: "N",
    option: "--normal-force",
    names: &[
        "normalforcen",
        "normalforce",
        "fn",
        "fnormal",
        "normalload",
        "load",
    ],
};

pub(super) const EXTERNAL_FORCE: Role = Role {
    words: "the external force",
    quantity: Quantity::Force,
    unit: "N",
    option: "--external-force",
    names: &[
        "externalforcen",
        "externalforce",
        "fext",
        "shaker",
        "shakerforce",
        "hammer",
        "motorforce",
    ],
};

pub(super) const CLAMP_ACCELERATION: Role = Role {
    words: "the acceleration of the clamp",
    quantity: Quantity::Acceleration,
    unit: "m/s^2",
    option: "--clamp-acceleration",
    names: &[
        "clampaccelerationmpers2",
        "clampacceleration",
        "baseacceleration",
        "aclamp",
        "abase",
    ],
};

/// Letters and digits of a name, in lower case.
pub(super) fn plain(name: &str) -> String {
    let kept = name.chars().filter(|c| c.is_alphanumeric());
    kept.flat_map(char::to_lowercase).collect()
}

pub(super) fn is_time_name(name: &str) -> bool {
    TIME.names.contains(&plain(name).as_str())
}

impl Role {
    pub(super) fn is_named(&self, channel: &Channel) -> bool {
        self.names.contains(&plain(channel.last_name()).as_str())
    }
}

pub(super) fn role_of(measurand: Measurand) -> &'static Role {
    match measurand {
        Measurand::Displacement => &DISPLACEMENT,
        Measurand::Velocity => &VELOCITY,
        Measurand::Acceleration => &ACCELERATION,
    }
}

pub(super) fn measures(channel: &Channel, quantity: Quantity) -> bool {
    match channel.unit {
        Some(unit) => unit.quantity == quantity,
        None => channel.strange_unit.is_none() && channel.kind == Some(quantity.words()),
    }
}

/// Whether a channel may become anything by a factor.
pub(super) fn may_be_scaled(channel: &Channel) -> bool {
    let strange = channel.strange_unit.as_deref();
    match channel.unit {
        Some(unit) => matches!(unit.quantity, Quantity::Voltage | Quantity::Other),
        None => channel.kind.is_none() && strange.and_then(names::strange_quantity).is_none(),
    }
}
