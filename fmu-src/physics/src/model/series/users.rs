//! Which effects use which hook on power series, found once for a model.

use super::MAX_PARTS;
use crate::effects::series::Hooks;
use crate::model::Enabled;

/// Places of effects in the model's list.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::model) struct Places {
    place: [u8; MAX_PARTS],
    count: u8,
}

impl Places {
    fn of(effects: &[Enabled], uses: impl Fn(&Hooks) -> bool) -> Self {
        let mut places = Self::default();
        for (i, e) in effects.iter().enumerate().take(MAX_PARTS) {
            if uses(&e.hooks) {
                places.place[usize::from(places.count)] = i as u8;
                places.count += 1;
            }
        }
        places
    }

    /// The places, in the order of the effects.
    #[inline]
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> + use<'_> {
        let used = &self.place[..usize::from(self.count)];
        used.iter().map(|i| usize::from(*i))
    }

    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }
}

/// The effects that use each hook; see [`Hooks`]. `any_factor` are those with a factor on the static limit, its own or
/// that of sliding.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::model) struct Users {
    pub(super) tip_force: Places,
    pub(super) modal_acceleration: Places,
    pub(super) lagged_speed: Places,
    pub(super) factor: Places,
    pub(super) any_factor: Places,
    pub(super) memory_force: Places,
    pub(super) rates: Places,
    pub(super) ripple: Places,
}

impl Users {
    pub(super) fn of(effects: &[Enabled]) -> Self {
        let of = |uses: fn(&Hooks) -> bool| Places::of(effects, uses);
        Self {
            tip_force: of(|h| h.tip_force),
            modal_acceleration: of(|h| h.modal_acceleration),
            lagged_speed: of(|h| h.lagged_speed),
            factor: of(|h| h.factor),
            any_factor: of(|h| h.factor || h.static_factor),
            memory_force: of(|h| h.memory_force),
            rates: of(|h| h.rates),
            ripple: of(|h| h.ripple),
        }
    }
}
