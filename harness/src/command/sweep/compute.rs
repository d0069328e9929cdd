//! The points of a study that are not done yet, on several threads, each stored as it is found.

use std::path::Path;

use beam_physics::sweep::Chain;

use super::plan::{Plan, Row};
use super::store::Store;
use crate::error::Error;
use crate::watch::Watch;

/// Computes what is not done yet into `folder`.
///
/// # Errors
/// A folder that can't be used, a disk that is full, a stop by the user.
pub(super) fn compute(
    plan: &Plan,
    rows: &[Row],
    folder: &Path,
    threads: usize,
    watch: &dyn Watch,
) -> Result<Store, Error> {
    let mut store = Store::open(folder, plan, rows)?;
    let chains = plan.chains(rows);
    compute_chains(plan, rows, chains, &mut store, (threads, folder), watch)?;
    store.sort(plan, rows)?;
    Ok(store)
}

/// Computes what is not done yet of these chains on so many threads; the folder is for messages.
pub(super) fn compute_chains(
    plan: &Plan,
    rows: &[Row],
    chains: Vec<Chain>,
    store: &mut Store,
    (threads, folder): (usize, &Path),
    watch: &dyn Watch,
) -> Result<(), Error> {
    let of = chains.iter().map(|chain| chain.tasks.len()).sum();
    let left = chains.into_iter().filter_map(|c| remaining(c, store));
    let chains: Vec<Chain> = left.collect();
    let ahead: usize = chains.iter().map(|chain| chain.tasks.len()).sum();
    let mut done = of - ahead;
    let mut problem = None;
    let mut stopped = false;
    watch.step("points", done, of);
    beam_physics::sweep::run(&chains, &plan.rule, threads, |outcome| {
        let motion = outcome.motion.as_ref().map_err(ToString::to_string);
        if let Err(error) = store.add(outcome.id, &rows[outcome.id], motion) {
            problem = Some(error);
            return false;
        }
        done += 1;
        watch.step("points", done, of);
        stopped = watch.stop();
        !stopped
    });
    if let Some(error) = problem {
        return Err(error);
    }
    if stopped && done < of {
        return Err(Error::Stopped {
            what: "points",
            done,
            of,
            folder: folder.into(),
        });
    }
    Ok(())
}

/// A chain without what is done, carrying on from there; `None` where nothing is left.
fn remaining(mut chain: Chain, store: &Store) -> Option<Chain> {
    let is_done = |id: usize| store.done[id].is_some();
    let begun = chain.tasks.iter().take_while(|t| is_done(t.id)).count();
    let before = chain.tasks.drain(..begun).rev();
    chain.carried = before.map(|t| store.carried[t.id].clone()).find_map(|c| c);
    chain.tasks.retain(|t| !is_done(t.id));
    (!chain.tasks.is_empty()).then_some(chain)
}
