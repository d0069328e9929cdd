//! Loading and running FMI 2.0 co-simulation FMUs, ours or anyone's, behind one small interface.
//!
//! ```no_run
//! # fn main() -> Result<(), stickslip::error::Error> {
//! use stickslip::fmu::Fmu;
//! let fmu = Fmu::load("StickSlipBeam.fmu".as_ref())?;
//! let force = fmu.variable("normal_force")?.reference;
//! let displacement = fmu.variable("tip_displacement")?.reference;
//! let mut beam = fmu.instantiate("beam")?; // cheap; one per thread
//! beam.set_real(&[force], &[60.0])?;
//! beam.initialize(0.0, None, None)?;
//! let mut w = [0.0];
//! beam.do_step(0.0, 1e-4)?;
//! beam.get_real(&[displacement], &mut w)?;
//! beam.reset()?; // ready for the next run
//! # Ok(()) }
//! ```
//!
//! Two backends do the calls: crate `fmi-rs`, and with the cargo feature `fmi-crate` crate `fmi`; a third, without a crate, serves
//! inputs with slopes alone. The description is
//! read here, so it is the same for both.

mod archive;
mod description;
mod drive;
mod edit_description;
pub mod effect_card;
#[cfg(feature = "fmi-crate")]
mod fmi_crate_backend;
mod fmi_rs_backend;
mod instance;
mod message_log;
mod parse_description;
mod raw_backend;
mod side_file;
mod slave;
mod status;
mod tangents;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use description::{
    Capabilities, Causality, DefaultExperiment, EnumItem, Kind, ModelDescription, Variable,
    VendorAnnotation,
};
pub use drive::{Course, Drive};
pub use edit_description::{with_guid, with_starts};
pub use instance::{Instance, State};
pub use side_file::{Belief, Constant, SideFile};
pub use status::Status;
pub use tangents::{Directions, Tangents};

use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use message_log::MessageLog;

/// FMI 2.0's name of the platform this program was built for, e.g. `linux64`.
pub const PLATFORM: &str = archive::PLATFORM;

/// Which crate talks to the binary. With the feature `fmi-crate` that one is the default, so that every test runs on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// Crate `fmi-rs`.
    #[cfg_attr(not(feature = "fmi-crate"), default)]
    FmiRs,
    /// Crate `fmi`.
    #[cfg(feature = "fmi-crate")]
    #[default]
    FmiCrate,
}

/// An unpacked FMU with a binary for this platform. Share it by reference between threads.
pub struct Fmu {
    pub(crate) loaded: Arc<Loaded>,
}

/// What instances need to outlive them: the folder and, for crate `fmi`, its import, which owns the folder.
pub(crate) struct Loaded {
    pub(crate) description: ModelDescription,
    path: PathBuf,
    source: Source,
    side_file: Option<SideFile>,
}

enum Source {
    FmiRs(tempfile::TempDir),
    #[cfg(feature = "fmi-crate")]
    FmiCrate(fmi::fmi2::import::Fmi2Import),
}

impl Fmu {
    /// Unpacks and checks an FMU; the binary itself is loaded by the first instance.
    pub fn load(path: &Path) -> Result<Fmu, Error> {
        Fmu::load_with(path, Backend::default())
    }

    /// The same with a given backend.
    pub fn load_with(path: &Path, backend: Backend) -> Result<Fmu, Error> {
        let folder = archive::unpack(path).map_err(|error| explain(error, path, Wanted::Fmu))?;
        let (description, _xml) = archive::describe(path, folder.path())?;
        archive::check_binary(path, folder.path(), &description.model_identifier)?;
        let side_file = SideFile::beside(path, &description)?;
        let source = match backend {
            Backend::FmiRs => Source::FmiRs(folder),
            #[cfg(feature = "fmi-crate")]
            Backend::FmiCrate => {
                let import = fmi::traits::FmiImport::new(folder, &_xml).map_err(|e| {
                    Error::FmuDescription {
                        path: path.to_owned(),
                        problem: e.to_string(),
                    }
                })?;
                Source::FmiCrate(import)
            }
        };
        Ok(Fmu {
            loaded: Arc::new(Loaded {
                description,
                path: path.to_owned(),
                source,
                side_file,
            }),
        })
    }

    /// A new instance. It belongs to the thread that makes it; many may live at once.
    pub fn instantiate(&self, name: &str) -> Result<Instance, Error> {
        let log = Arc::new(MessageLog::default());
        let refused = |reason: String| {
            let said = log.take();
            let reason = if said.is_empty() {
                reason
            } else {
                format!("{reason}: {said}")
            };
            Error::FmuInstantiate {
                path: self.loaded.path.clone(),
                reason,
            }
        };
        let slave: Box<dyn slave::Slave> = match &self.loaded.source {
            Source::FmiRs(folder) => Box::new(
                fmi_rs_backend::instantiate(
                    folder.path(),
                    self.description(),
                    name,
                    false,
                    log.clone(),
                )
                .map_err(refused)?,
            ),
            #[cfg(feature = "fmi-crate")]
            Source::FmiCrate(import) => {
                Box::new(fmi_crate_backend::instantiate(import, name, false).map_err(refused)?)
            }
        };
        Ok(Instance::new(self, slave, log, name))
    }

    /// A new instance whose inputs can be given slopes ([`Instance::set_input_rates`]), but whose state can't be saved.
    ///
    /// # Errors
    /// An FMU that gives no instance.
    pub fn instantiate_driven(&self, name: &str) -> Result<Instance, Error> {
        let log = Arc::new(MessageLog::default());
        let slave = raw_backend::instantiate(self.folder(), self.description(), name, log.clone());
        let slave = slave.map_err(|reason| Error::FmuInstantiate {
            path: self.loaded.path.clone(),
            reason: format!("{reason} {}", log.take()).trim().to_owned(),
        })?;
        Ok(Instance::new(self, Box::new(slave), log, name))
    }

    /// An instance that gives derivatives along a motion, if this FMU offers that (ours does).
    pub fn tangents(&self) -> Option<Tangents> {
        Tangents::new(self)
    }

    /// The folder into which the FMU was unpacked.
    fn folder(&self) -> &Path {
        match &self.loaded.source {
            Source::FmiRs(folder) => folder.path(),
            #[cfg(feature = "fmi-crate")]
            Source::FmiCrate(import) => fmi::traits::FmiImport::archive_path(import),
        }
    }

    /// What the FMU says about itself.
    pub fn description(&self) -> &ModelDescription {
        &self.loaded.description
    }

    /// Where it was loaded from.
    pub fn path(&self) -> &Path {
        &self.loaded.path
    }

    /// Everything in the archive: path inside it with forward slashes, and content; modelDescription.xml first.
    ///
    /// # Errors
    /// An unpacked file that can't be read any more.
    pub fn files(&self) -> Result<Vec<(String, Vec<u8>)>, Error> {
        archive::files(self.folder())
    }

    /// What stands beside an FMU of another make.
    pub fn side_file(&self) -> Option<&SideFile> {
        self.loaded.side_file.as_ref()
    }

    /// The FMU's own name of a variable: that which its side file says, or the same.
    pub fn own_name<'n>(&'n self, name: &'n str) -> &'n str {
        let stated = self.side_file().and_then(|side| side.own_name(name));
        stated.unwrap_or(name)
    }

    /// The variable of this name, be it the FMU's own or one that its side file explains, or an error with similar names.
    pub fn variable(&self, name: &str) -> Result<&Variable, Error> {
        let unknown = || {
            let unnamed = self.side_file().and_then(|side| side.unnamed(name));
            unnamed.unwrap_or_else(|| Error::UnknownVariable {
                path: self.loaded.path.clone(),
                name: name.to_owned(),
                nearest: self.description().nearest(name),
            })
        };
        self.description()
            .find(self.own_name(name))
            .ok_or_else(unknown)
    }

    /// Value references of Real variables, in the order of `names`.
    pub fn real_references(&self, names: &[&str]) -> Result<Vec<u32>, Error> {
        let reference = |name: &&str| {
            let variable = self.variable(name)?;
            let wrong = || Error::VariableValue {
                name: variable.name.clone(),
                kind: "not a Real",
                value: "a real number".into(),
                rule: "the FMU must declare it as Real",
            };
            if variable.kind == Kind::Real {
                Ok(variable.reference)
            } else {
                Err(wrong())
            }
        };
        names.iter().map(reference).collect()
    }
}
