//! Random sequences of calls: nothing crashes, no call is accepted that the standard forbids, none refused that it
//! allows (FMI 2.0.5, tables in 3.2.3 and 4.2.4; 2.1.7 for arguments). The tables below are written from the
//! standard, not from the FMU's own.
//!
//! A short run by default; `FUZZ_CALLS=1000000 cargo test --release --test fmi_fuzz -- --nocapture` is the long one
//! (docs/fuzzing.md), `FUZZ_SEED` another sequence.

use std::ffi::{c_int, c_void};
use stickslip_tests::exchange::{EventInfo, INDICATORS, STATES};
use stickslip_tests::slave::{DISCARD, ERROR, OK, Slave};
use stickslip_tests::variables::{guid, reference};

/// State of an instance in the standard's words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Instantiated,
    Initialization,
    StepComplete,
    EventMode,
    ContinuousTime,
    Terminated,
}
use Phase::{ContinuousTime, EventMode, Initialization, Instantiated, StepComplete, Terminated};

/// xorshift64* (Vigna 2016).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
    fn share(&mut self) -> f64 {
        self.next() as f64 / (1_u64 << 53) as f64
    }
    fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// An instance and what it should be.
struct Actor {
    slave: Slave,
    exchange: bool,
    phase: Phase,
    time: f64,
}

/// A state taken from an instance.
struct Kept {
    state: *mut c_void,
    exchange: bool,
    phase: Phase,
    time: f64,
}

/// What a call must answer.
#[derive(Debug, PartialEq)]
enum Answer {
    Done,
    Refused,
    /// Either: states far off may not be evaluable, which is no error of the call.
    DoneOrDiscarded,
}
use Answer::{Done, DoneOrDiscarded, Refused};

/// The section of FMI 2.0.5 that defines a call; when it is legal, the tables in 3.2.3 and 4.2.4 say as well.
fn clause(call: &str) -> &'static str {
    match call {
        "SetDebugLogging" => "2.1.5",
        "SetupExperiment"
        | "EnterInitializationMode"
        | "ExitInitializationMode"
        | "Terminate"
        | "Reset" => "2.1.6",
        // Which variables may be set when: the table of causalities and variabilities.
        "SetReal of an input"
        | "SetReal of a tunable parameter"
        | "SetReal of a start value"
        | "SetReal of a result" => "2.1.7, 2.2.7",
        "GetReal" | "SetInteger" => "2.1.7",
        "GetFMUstate" | "SetFMUstate" | "FreeFMUstate" | "DeSerializeFMUstate" => "2.1.8",
        "GetDirectionalDerivative" => "2.1.9",
        "SetTime" | "SetContinuousStates" => "3.2.1",
        "EnterEventMode"
        | "NewDiscreteStates"
        | "EnterContinuousTimeMode"
        | "GetDerivatives"
        | "GetEventIndicators"
        | "GetContinuousStates" => "3.2.2",
        "SetRealInputDerivatives" | "GetRealOutputDerivatives" => "4.2.1",
        "DoStep" => "4.2.2",
        other => panic!("say where the standard defines {other}"),
    }
}

impl Actor {
    fn new(random: &mut Random) -> Self {
        let exchange = random.below(2) == 0;
        let kind = c_int::from(!exchange);
        let name = random.pick(&["a", "100%s", "Prüfling", "a name with spaces"]);
        let slave = Slave::instantiate(name, kind, Some(guid()), None, random.below(2) as c_int);
        Self {
            slave: slave.unwrap_or_else(|m| panic!("{m:?}")),
            exchange,
            phase: Instantiated,
            time: 0.0,
        }
    }

    fn in_one(&self, phases: &[Phase]) -> bool {
        phases.contains(&self.phase)
    }

    /// One random call: its name, what it answered, what it should.
    fn call(&mut self, random: &mut Random, kept: &mut Vec<Kept>) -> (&'static str, c_int, Answer) {
        const READ: [Phase; 5] = [
            Initialization,
            StepComplete,
            EventMode,
            ContinuousTime,
            Terminated,
        ];
        const RUN: [Phase; 3] = [StepComplete, EventMode, ContinuousTime];
        let legal = |ok: bool| if ok { Done } else { Refused };
        // In model exchange the master can bring the states where nothing can be computed.
        let computed = |ok: bool| match ok {
            false => Refused,
            true if self.exchange => DoneOrDiscarded,
            true => Done,
        };
        let n = STATES.len();
        let (slave, phase, exchange) = (&self.slave, self.phase, self.exchange);
        let share = random.share();
        match random.below(30) {
            0 => {
                let ok = phase == Instantiated;
                let (tolerance, start) = (random.pick(&[None, Some(1e-6), Some(1e-9)]), 0.0);
                let status = slave.experiment(tolerance, start, random.pick(&[None, Some(1e6)]));
                ("SetupExperiment", status, legal(ok))
            }
            1 | 2 => {
                let ok = phase == Instantiated;
                if ok {
                    self.phase = Initialization;
                }
                ("EnterInitializationMode", self.slave.enter(), legal(ok))
            }
            3 | 4 => {
                let ok = phase == Initialization;
                let status = slave.exit();
                if ok {
                    self.phase = if exchange { EventMode } else { StepComplete };
                }
                ("ExitInitializationMode", status, legal(ok))
            }
            5 if random.below(8) == 0 => {
                let ok = self.in_one(&RUN);
                let status = self.slave.terminate();
                if ok {
                    self.phase = Terminated;
                }
                ("Terminate", status, legal(ok))
            }
            6 if random.below(8) == 0 => {
                let status = slave.reset();
                (self.phase, self.time) = (Instantiated, 0.0);
                ("Reset", status, Done)
            }
            7 => {
                let name = random.pick(&[
                    "tip_velocity",
                    "friction.mu_0",
                    "der(q_dot[1])",
                    "belt_distance",
                ]);
                let known = random.below(4) > 0;
                let vr = if known {
                    reference(name)
                } else {
                    random.pick(&[0, 15, 8999, u32::MAX])
                };
                let mut value = [f64::NAN];
                let status = slave.get_into(&[vr], &mut value);
                assert!(status != OK || value[0].is_finite(), "{name} = {value:?}");
                ("GetReal", status, computed(known && self.in_one(&READ)))
            }
            8 => {
                let name = random.pick(&[
                    "belt_velocity",
                    "normal_force",
                    "external_force",
                    "clamp_acceleration",
                ]);
                let usual = if name == "belt_velocity" { 0.1 } else { 100.0 };
                let value = random.pick(&[f64::NAN, usual, usual * (0.5 + share), f64::INFINITY]);
                let ok = value.is_finite() && phase != Terminated;
                ("SetReal of an input", slave.set(name, value), legal(ok))
            }
            9 => {
                let (name, usual) = random.pick(&[
                    ("friction.mu_0", 0.66),
                    ("friction.level", 1.0),
                    ("third_mode.damping_ratio", 1e-3),
                    ("sensor_lag.time_constant", 1e-4),
                    ("mode[2].frequency", 510.0),
                ]);
                let value = usual * (0.9 + 0.2 * share);
                let ok = self.in_one(&[Instantiated, Initialization, StepComplete, EventMode]);
                (
                    "SetReal of a tunable parameter",
                    slave.set(name, value),
                    legal(ok),
                )
            }
            10 => {
                let ok = self.in_one(&[Instantiated, Initialization]);
                let value = 1e-3 * share;
                (
                    "SetReal of a start value",
                    slave.set("q[1]", value),
                    legal(ok),
                )
            }
            11 => (
                "SetReal of a result",
                slave.set("tip_velocity", 0.0),
                Refused,
            ),
            12 => {
                let ok = self.in_one(&[Instantiated, Initialization]);
                let modes = random.pick(&[2, 3, 99]);
                (
                    "SetInteger",
                    slave.set_integer("mode_count", modes),
                    legal(ok && modes < 9),
                )
            }
            13..=15 => {
                let step =
                    random.pick(&[1e-4, 1e-3, 2e-3 * share + 1e-9, 0.0, -1e-3, f64::NAN, 1e-14]);
                let off = random.pick(&[0.0, 0.0, 0.0, 0.0, 1.0, f64::NAN, -1.0]);
                let ok = phase == StepComplete && step > 0.0 && off == 0.0;
                let status = slave.step(self.time + off, step);
                if ok {
                    self.time += step;
                }
                ("DoStep", status, legal(ok))
            }
            16 => {
                let ok = !exchange && self.in_one(&[Instantiated, Initialization, StepComplete]);
                let order = random.pick(&[1, 1, 1, 0, 2]);
                let status = slave.set_rate("belt_velocity", order, share);
                ("SetRealInputDerivatives", status, legal(ok && order == 1))
            }
            17 => {
                let ok = !exchange && self.in_one(&[StepComplete, Terminated]);
                let status = slave.rate_into("tip_velocity", 1, &mut 0.0);
                ("GetRealOutputDerivatives", status, legal(ok))
            }
            18 => {
                let ok = self.in_one(&READ);
                let vr = [reference("friction_force"), reference("normal_force")];
                let status = slave.directional(&vr[..1], &vr[1..], &[1.0], &mut [0.0]);
                ("GetDirectionalDerivative", status, computed(ok))
            }
            19 => {
                let ok = self.in_one(&[EventMode, ContinuousTime]);
                if ok {
                    self.phase = EventMode;
                }
                (
                    "EnterEventMode",
                    self.slave.plain_call("fmi2EnterEventMode"),
                    legal(ok),
                )
            }
            20 => {
                let ok = phase == EventMode;
                let status = slave.new_discrete_states_into(&mut EventInfo::default());
                ("NewDiscreteStates", status, computed(ok))
            }
            21 => {
                let ok = phase == EventMode;
                if ok {
                    self.phase = ContinuousTime;
                }
                let status = self.slave.plain_call("fmi2EnterContinuousTimeMode");
                ("EnterContinuousTimeMode", status, legal(ok))
            }
            22 => {
                let time = random.pick(&[self.time + 1e-4 * share, f64::NAN]);
                let ok = time.is_finite() && self.in_one(&[EventMode, ContinuousTime]);
                if ok {
                    self.time = time;
                }
                ("SetTime", self.slave.set_time(time), legal(ok))
            }
            23 => {
                let count = random.pick(&[n, n, n, n - 1, 0]);
                let scale = random.pick(&[1e-4, 1.0, 1e300]);
                let states: Vec<f64> = (0..count).map(|_| scale * random.share()).collect();
                let ok = phase == ContinuousTime && count == n;
                ("SetContinuousStates", slave.set_states(&states), legal(ok))
            }
            24 => {
                let count = random.pick(&[n, n, n, n + 1]);
                let ok =
                    self.in_one(&[EventMode, ContinuousTime, Terminated]) && exchange && count == n;
                let status = slave.fill("fmi2GetDerivatives", &mut vec![0.0; count]);
                (
                    "GetDerivatives",
                    status,
                    if ok { DoneOrDiscarded } else { Refused },
                )
            }
            25 => {
                let ok = exchange && self.in_one(&READ);
                let status = slave.fill("fmi2GetEventIndicators", &mut [0.0; INDICATORS]);
                (
                    "GetEventIndicators",
                    status,
                    if ok { DoneOrDiscarded } else { Refused },
                )
            }
            26 => {
                let ok = exchange && self.in_one(&READ);
                let status = slave.fill("fmi2GetContinuousStates", &mut vec![0.0; n]);
                ("GetContinuousStates", status, legal(ok))
            }
            27 => {
                if kept.len() > 20 {
                    let mut old = kept.swap_remove(random.below(kept.len()));
                    return ("FreeFMUstate", slave.free_state(&mut old.state), Done);
                }
                let state = slave.state();
                kept.push(Kept {
                    state,
                    exchange,
                    phase,
                    time: self.time,
                });
                ("GetFMUstate", OK, Done)
            }
            28 if !kept.is_empty() => {
                let one = &kept[random.below(kept.len())];
                let ok = one.exchange == exchange;
                let status = slave.set_state(one.state);
                if ok {
                    (self.phase, self.time) = (one.phase, one.time);
                }
                ("SetFMUstate", status, legal(ok))
            }
            29 if !kept.is_empty() => {
                let one = &kept[random.below(kept.len())];
                let mut bytes = slave.serialize(one.state);
                let damaged = random.below(2) == 0;
                if damaged {
                    let place = random.below(bytes.len());
                    bytes[place] ^= 1 << random.below(8);
                }
                let answer = legal(!damaged && one.exchange == exchange);
                match slave.deserialize(&bytes) {
                    Ok(mut state) => ("DeSerializeFMUstate", slave.free_state(&mut state), answer),
                    Err(status) => ("DeSerializeFMUstate", status, answer),
                }
            }
            _ => {
                let category = random.pick(&[c"logAll", c"logStatusError", c"nonsense"]);
                let status = slave.debug_logging(random.below(2) == 0, &[category]);
                ("SetDebugLogging", status, legal(category != c"nonsense"))
            }
        }
    }
}

/// Resident memory of this process in kB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmRSS"));
    line.and_then(|l| l.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}

#[test]
fn random_calls_are_answered_as_the_standard_says() {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .and_then(|text| text.parse::<u64>().ok())
    };
    let calls = number("FUZZ_CALLS").unwrap_or(30_000);
    let seed = number("FUZZ_SEED").unwrap_or(1);
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut actors: Vec<Actor> = (0..6).map(|_| Actor::new(&mut random)).collect();
    let mut kept: Vec<Kept> = Vec::new();
    let mut seen = std::collections::BTreeMap::<&str, [u64; 2]>::new();
    let mut trace = std::collections::VecDeque::new();
    let mut memory = 0;
    for i in 0..calls {
        if i == calls / 4 {
            memory = resident();
        }
        let who = random.below(actors.len());
        if random.below(200) == 0 {
            actors[who] = Actor::new(&mut random);
        }
        let actor = &mut actors[who];
        let before = actor.phase;
        let (name, status, expected) = actor.call(&mut random, &mut kept);
        trace.push_back(format!("{who} {name} in {before:?}: {status}"));
        if trace.len() > 90 {
            trace.pop_front();
        }
        let messages = actor.slave.messages();
        let fits = match expected {
            Done => status == OK,
            Refused => status == ERROR && messages.iter().any(|m| m.category == "logStatusError"),
            DoneOrDiscarded => status == OK || status == DISCARD,
        };
        if !fits {
            // What stands in the instance, to find the cause.
            for name in [
                "belt_velocity",
                "normal_force",
                "friction.mu_0",
                "friction.level",
                "sensor_lag.time_constant",
                "mode[2].frequency",
                "q[1]",
                "q_dot[1]",
                "q[2]",
                "q_dot[2]",
                "q[3]",
                "q_dot[3]",
                "sensor_lag.state.reading",
                "relative_velocity",
            ] {
                let mut value = [f64::NAN];
                let status = actor.slave.get_into(&[reference(name)], &mut value);
                println!("{name} = {:?} ({status})", value[0]);
            }
            println!("expected time {}", actor.time);
        }
        let clause = clause(name);
        assert!(
            fits,
            "seed {seed}, call {i}: {name} in {before:?} (model exchange: {}) answered {status}, not {expected:?} \
             (FMI 2.0.5, {clause})\n{messages:?}\n{trace:#?}",
            actor.exchange
        );
        // A model that was driven off (states of 1e300) starts afresh, or nothing else would be seen.
        if status == DISCARD {
            assert_eq!(actor.slave.reset(), OK);
            (actor.phase, actor.time) = (Instantiated, 0.0);
        }
        seen.entry(name).or_default()[usize::from(status != OK)] += 1;
    }
    for one in &mut kept {
        assert_eq!(actors[0].slave.free_state(&mut one.state), OK);
    }
    println!("{calls} calls, seed {seed}: section of FMI 2.0.5, done, refused");
    for (name, [done, refused]) in &seen {
        println!("{name:32} {:11} {done:8} {refused:8}", clause(name));
    }
    let grown = resident().saturating_sub(memory);
    println!("memory after the first quarter: {memory} kB, grown by {grown} kB");
    // Under valgrind (tests/valgrind.sh) freed memory stays with the process, and leaks are looked for exactly.
    if std::env::var_os("FUZZ_MEMORY").is_none() {
        assert!(grown < 3_000, "{grown} kB");
    }
    assert!(seen.len() >= 24, "{}", seen.len());
    // Of every function both answers were met, but for those that are legal always.
    let always = ["GetFMUstate", "FreeFMUstate", "Reset"];
    for (name, [done, refused]) in &seen {
        assert!(*done > 0 || name.contains("of a result"), "{name}");
        assert!(*refused > 0 || always.contains(name), "{name}");
    }
}
