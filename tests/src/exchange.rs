//! The calls of model exchange (FMI 2.0.5, section 3.2), and an integrator as plain as can be.

use crate::slave::{OK, Slave, function};
use crate::variables::{XML, guid};
use std::ffi::{c_int, c_void};
use std::sync::LazyLock;

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EventInfo {
    /// Another call is needed.
    pub needed: c_int,
    /// The simulation should end.
    pub terminate: c_int,
    /// Nominal values have changed.
    pub nominals: c_int,
    /// States have jumped.
    pub values: c_int,
    /// There is a next time event.
    pub defined: c_int,
    /// Its time in s.
    pub time: f64,
}

/// Names of the continuous states in the order of the state vector, as the description has it.
pub static STATES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let document = roxmltree::Document::parse(&XML).expect("well-formed");
    let variables: Vec<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("ScalarVariable"))
        .collect();
    let list = document
        .descendants()
        .find(|n| n.has_tag_name("Derivatives"))
        .expect("model exchange has some");
    list.children()
        .filter(roxmltree::Node::is_element)
        .map(|unknown| {
            let index: usize = unknown
                .attribute("index")
                .expect("required")
                .parse()
                .expect("number");
            let real = variables[index - 1].first_element_child().expect("typed");
            let state = real.attribute("derivative").expect("a rate");
            let state: usize = state.parse().expect("number");
            variables[state - 1]
                .attribute("name")
                .expect("named")
                .to_owned()
        })
        .collect()
});

/// Event indicators of the description.
pub const INDICATORS: usize = 3;

type Fill = unsafe extern "C" fn(*mut c_void, *mut f64, usize) -> c_int;

impl Slave {
    /// A fresh instance for model exchange.
    pub fn new_exchange() -> Self {
        Self::instantiate("test", 0, Some(guid()), None, 0).expect("a legal call")
    }

    /// An instance for model exchange in continuous-time mode at 0 s.
    pub fn started_exchange(set: &[(&str, f64)]) -> Self {
        let slave = Self::new_exchange();
        for (name, value) in set {
            assert_eq!(slave.set(name, *value), OK, "{name}");
        }
        slave.start_at(0.0);
        assert_eq!(slave.new_discrete_states().needed, 0);
        assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK);
        slave
    }

    /// A function whose only argument is the handle.
    pub fn plain_call(&self, name: &str) -> c_int {
        // SAFETY: the type is that of the standard, the handle is live.
        unsafe { function::<unsafe extern "C" fn(*mut c_void) -> c_int>(name)(self.component) }
    }

    /// `fmi2NewDiscreteStates`, which must succeed.
    pub fn new_discrete_states(&self) -> EventInfo {
        let mut info = EventInfo::default();
        assert_eq!(
            self.new_discrete_states_into(&mut info),
            OK,
            "{:?}",
            self.messages()
        );
        info
    }

    /// `fmi2NewDiscreteStates`.
    pub fn new_discrete_states_into(&self, info: &mut EventInfo) -> c_int {
        type Call = unsafe extern "C" fn(*mut c_void, *mut EventInfo) -> c_int;
        // SAFETY: as above.
        unsafe { function::<Call>("fmi2NewDiscreteStates")(self.component, info) }
    }

    /// `fmi2SetTime`, in s.
    pub fn set_time(&self, time: f64) -> c_int {
        type Call = unsafe extern "C" fn(*mut c_void, f64) -> c_int;
        // SAFETY: as above.
        unsafe { function::<Call>("fmi2SetTime")(self.component, time) }
    }

    /// `fmi2SetContinuousStates`.
    pub fn set_states(&self, states: &[f64]) -> c_int {
        type Call = unsafe extern "C" fn(*mut c_void, *const f64, usize) -> c_int;
        // SAFETY: as above; the length is the slice's.
        unsafe {
            function::<Call>("fmi2SetContinuousStates")(
                self.component,
                states.as_ptr(),
                states.len(),
            )
        }
    }

    /// One of the functions that fill an array of reals.
    pub fn fill(&self, name: &str, values: &mut [f64]) -> c_int {
        // SAFETY: as above.
        unsafe { function::<Fill>(name)(self.component, values.as_mut_ptr(), values.len()) }
    }

    fn filled(&self, name: &str, count: usize) -> Vec<f64> {
        let mut values = vec![f64::NAN; count];
        assert_eq!(
            self.fill(name, &mut values),
            OK,
            "{name}: {:?}",
            self.messages()
        );
        values
    }

    /// `fmi2GetContinuousStates`.
    pub fn states(&self) -> Vec<f64> {
        self.filled("fmi2GetContinuousStates", STATES.len())
    }

    /// `fmi2GetDerivatives`.
    pub fn derivatives(&self) -> Vec<f64> {
        self.filled("fmi2GetDerivatives", STATES.len())
    }

    /// `fmi2GetEventIndicators`.
    pub fn indicators(&self) -> Vec<f64> {
        self.filled("fmi2GetEventIndicators", INDICATORS)
    }

    /// `fmi2GetDirectionalDerivative`.
    pub fn directional(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> c_int {
        assert_eq!((unknowns.len(), knowns.len()), (out.len(), seed.len()));
        type Call = unsafe extern "C" fn(
            *mut c_void,
            *const u32,
            usize,
            *const u32,
            usize,
            *const f64,
            *mut f64,
        ) -> c_int;
        // SAFETY: as above; all lengths are those of the slices.
        unsafe {
            function::<Call>("fmi2GetDirectionalDerivative")(
                self.component,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                out.as_mut_ptr(),
            )
        }
    }

    /// Handles an event at the present time; true where states have jumped.
    pub fn event(&self) -> bool {
        assert_eq!(self.plain_call("fmi2EnterEventMode"), OK);
        let info = self.new_discrete_states();
        assert_eq!(self.plain_call("fmi2EnterContinuousTimeMode"), OK);
        info.values != 0
    }
}

/// A run of an instance in continuous-time mode: classical Runge-Kutta steps of a fixed size, and bisection
/// down to rounding where an event indicator leaves its domain.
pub struct Integration<'a> {
    /// The instance.
    pub slave: &'a Slave,
    /// Present time in s.
    pub time: f64,
    states: Vec<f64>,
    indicators: Vec<f64>,
    /// Called with the time in s before every look at the equations, to set inputs.
    pub inputs: &'a dyn Fn(&Slave, f64),
}

impl<'a> Integration<'a> {
    /// A run from `time` in s on.
    pub fn new(slave: &'a Slave, time: f64, inputs: &'a dyn Fn(&Slave, f64)) -> Self {
        Self {
            slave,
            time,
            states: slave.states(),
            indicators: slave.indicators(),
            inputs,
        }
    }

    fn go_to(&self, time: f64, states: &[f64]) {
        assert_eq!(self.slave.set_time(time), OK);
        (self.inputs)(self.slave, time);
        assert_eq!(self.slave.set_states(states), OK);
    }

    fn ahead(&self, rates: &[f64], h: f64) -> Vec<f64> {
        self.states
            .iter()
            .zip(rates)
            .map(|(x, r)| x + h * r)
            .collect()
    }

    fn rates_at(&self, h: f64, states: &[f64]) -> Vec<f64> {
        self.go_to(self.time + h, states);
        self.slave.derivatives()
    }

    /// States after a step; the instance stands there.
    fn step(&self, h: f64) -> Vec<f64> {
        let k1 = self.rates_at(0.0, &self.states);
        let k2 = self.rates_at(h / 2.0, &self.ahead(&k1, h / 2.0));
        let k3 = self.rates_at(h / 2.0, &self.ahead(&k2, h / 2.0));
        let k4 = self.rates_at(h, &self.ahead(&k3, h));
        let mean: Vec<f64> = (0..k1.len())
            .map(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0)
            .collect();
        let end = self.ahead(&mean, h);
        self.go_to(self.time + h, &end);
        end
    }

    fn left_domain(&self) -> bool {
        let now = self.slave.indicators();
        now.iter()
            .zip(&self.indicators)
            .any(|(a, b)| (*a > 0.0) != (*b > 0.0))
    }

    /// Runs to `end` in s in steps of `h` s.
    pub fn run(&mut self, end: f64, h: f64) {
        while self.time < end - 1e-12 {
            let h = h.min(end - self.time);
            let mut length = h;
            let mut next = self.step(h);
            if self.left_domain() {
                let (mut low, mut high) = (0.0, h);
                while high - low > 1e-16 {
                    let middle = 0.5 * (low + high);
                    self.step(middle);
                    *(if self.left_domain() {
                        &mut high
                    } else {
                        &mut low
                    }) = middle;
                }
                length = high;
                next = self.step(high);
                if self.slave.event() {
                    next = self.slave.states();
                }
            }
            self.time += length;
            self.states = next;
            self.indicators = self.slave.indicators();
        }
    }
}
