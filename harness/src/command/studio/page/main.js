// The page: keeps draft, base and run, asks for predictions, follows the board. What is decided is decided by the server.

import { build, element } from './controls.js';
import * as drop from './drop.js';
import * as history from './history.js';
import * as plots from './plots.js';
import { Gone, board as readBoard, client, get, latest, post } from './server.js';

const REST = 350;
const byId = (id) => document.getElementById(id);
const percent = (value) => (value === null || value === undefined ? '–' : `${(100 * value).toPrecision(4)} %`);
const copy = (value) => JSON.parse(JSON.stringify(value));

const state = {
  campaign: null, board: null, draft: null, base: 0, run: 0, pair: [null, null], other: null, held: new Set(), errors: null,
  runName: () => state.campaign.runs[state.run].name,
};
let showControls = () => {};
let resting = 0;
let linked = false;
let curves = null;

function trouble(text) {
  byId('trouble').hidden = !text;
  byId('trouble').textContent = text ?? '';
}
function warn(text) { byId('warning').textContent = text ?? ''; }

function say(errors, careful) {
  const about = careful ? '' : '≈ ';
  byId('error').textContent = errors.fitted === null ? '–' : `${about}${percent(errors.fitted)}`;
  byId('kept-out').textContent = errors.kept_out === null ? '–' : `${about}${percent(errors.kept_out)}`;
  warn(errors.ran_away
    ? `The motion runs away from the measurement in ${errors.ran_away} of ${errors.segments} segments at these values; ` +
      'the curves end there.' : '');
}

const question = (careful) => ({ client, draft: state.draft, base: state.base, run: state.run, careful, shown: true });
const predict = latest((found, asked, begun, newest) => {
  if (asked.run !== state.run) return;
  state.errors = found.errors;
  curves = found.curves;
  say(found.errors, found.careful);
  redraw();
  const whole = performance.now() - begun;
  document.body.dataset.latency = whole.toFixed(1);
  // An answer on its way when the model changed is drawn, but is not the answer to what is on the page now.
  document.body.dataset.settled = String(found.careful && newest);
  byId('latency').textContent = `${found.careful ? 'starts found' : 'starts estimated'}, ${found.milliseconds.toFixed(0)} ms`;
}, (error) => { if (error instanceof Gone) trouble(error.message); else warn(error.message); });

const predictOther = latest((found, asked) => {
  const rung = state.board.rungs.find((r) => r.id === asked.base);
  state.other = rung ? { name: rung.name, curves: found.curves } : null;
  redraw();
}, (error) => warn(error.message));

function redraw() {
  if (!curves) return;
  plots.show({ run: state.campaign.runs[state.run], curves, other: state.other },
    () => plots.map(state.campaign.runs, state.errors?.by_run, state.run, chooseRun));
  if (!linked) { plots.link(); linked = true; }
}

/** Asks for the model on the page; what is shown until the answer comes is that of before. */
function ask(careful) {
  document.body.dataset.settled = 'false';
  predict(question(careful));
}

/** The draft has changed: predicts at once, and with care once it rests. */
function changed() {
  ask(false);
  clearTimeout(resting);
  resting = setTimeout(() => ask(true), REST);
}

function compareWith() {
  const id = state.pair.find((one) => one !== null && one !== state.base) ?? null;
  const rung = state.board.rungs.find((r) => r.id === id);
  if (!rung) { state.other = null; redraw(); return; }
  predictOther({ client: `${client}-other`, draft: rung.draft, base: rung.id, run: state.run, careful: true, shown: false });
}

function chooseRun(index) {
  if (index === state.run) return;
  state.run = index;
  plots.unzoom();
  showRuns();
  showControls();
  ask(true);
  compareWith();
}

function showRuns() {
  byId('run-name').textContent = state.runName();
  byId('runs').replaceChildren(...state.campaign.runs.map((run, i) => {
    const button = element('button', { className: i === state.run ? 'on' : '' }, run.name);
    button.title = `${run.belt_velocity} m/s, ${run.normal_force} N, ${run.duration_s.toPrecision(3)} s${run.kept_out ? ', kept out' : ''}`;
    button.setAttribute('aria-pressed', String(i === state.run));
    button.addEventListener('click', () => chooseRun(i));
    return button;
  }));
}

/** Takes a model over: of a rung, of another page, of a fit. */
function adopt(draft, base) {
  state.draft = copy(draft);
  state.base = base;
  showControls();
}

async function openCampaign(board) {
  state.campaign = await get('api/campaign');
  state.run = Math.min(state.run, state.campaign.runs.length - 1);
  state.pair = [null, null];
  state.other = null;
  state.held = new Set();
  state.draft = copy(board.draft);
  state.base = board.base;
  byId('campaign').textContent = state.campaign.name;
  document.title = `${state.campaign.name} – stickslip studio`;
  showControls = build(state.campaign.controls, state, changed);
  showRuns();
  plots.unzoom();
  plots.reads(state.campaign.quantity);
  const { name } = state.campaign.quantity;
  byId('quantity').textContent = `${name[0].toUpperCase()}${name.slice(1)}`;
  const about = { campaign: state.campaign.folder, FMU: state.campaign.fmu, output: state.campaign.output,
    segments: `${state.campaign.segments}, horizon ${(1e3 * state.campaign.horizon_s).toPrecision(3)} ms` };
  byId('about').replaceChildren(...Object.entries(about).flatMap(([k, v]) => [element('dt', {}, k), element('dd', {}, v)]),
    ...state.campaign.remarks.flatMap((r) => [element('dt', {}, 'remark'), element('dd', {}, r)]));
  ask(true);
}

const order = async (job) => {
  warn('');
  try { await post('api/work', job); } catch (error) { if (error instanceof Gone) trouble(error.message); else warn(error.message); }
};
const model = () => ({ draft: state.draft, base: state.base });

/** Names that a fit may move; null where all are ticked. */
function free() {
  if (!state.held.size) return null;
  const all = [...state.campaign.controls.nuisances,
    ...state.campaign.controls.effects.filter((e) => e.id in state.draft.effects).flatMap((e) => e.parameters)];
  return all.map((c) => c.name).filter((name) => !state.held.has(name));
}

function showProgress(progress) {
  byId('work').hidden = !progress;
  for (const id of ['fit', 'score', 'diagnose', 'keep', 'reload']) byId(id).disabled = Boolean(progress) || !state.board?.is_open;
  byId('cancel').disabled = !progress;
  if (!progress) return;
  byId('outcome').hidden = true;
  byId('work-what').textContent = progress.what;
  byId('work-words').textContent = progress.words;
  if (progress.share === null) byId('work-share').removeAttribute('value'); else byId('work-share').value = progress.share;
  byId('work-errors').hidden = progress.errors.length < 2;
  if (progress.errors.length > 1) plots.falling(progress.errors);
}

const act = {
  restore: (rung) => { adopt(rung.draft, rung.id); state.board.base = rung.id; ask(true); showLadder(); },
  forget: async (rung) => { try { await post('api/forget', { rung: rung.id }); } catch (error) { warn(error.message); } },
  exported: (rung) => order({ kind: 'export', rung: rung.id }),
  beside: (side, id) => { state.pair[side] = id; compareWith(); showLadder(); },
  switchOn: (id, start) => {
    if (start) state.draft = copy(start); else state.draft.effects[id] = {};
    showControls();
    changed();
    byId(`effect-${id}`)?.focus();
  },
};
function showLadder() {
  history.ladder({ ...state.board, base: state.base }, state.pair, act);
  history.beside(state.board, state.pair, state.campaign.runs).catch((error) => warn(error.message));
}

async function follow(next) {
  const before = state.board;
  state.board = next;
  trouble(next.trouble);
  if (next.is_open && (!before || before.opened !== next.opened)) await openCampaign(next);
  const ended = next.outcome && next.outcome.id !== (before?.outcome?.id ?? 0);
  const moved = before && next.outcome?.finding && ['rung', 'diagnosis'].includes(next.outcome.finding.kind);
  if (next.is_open && state.draft) {
    if (next.progress?.draft) {
      adopt(next.progress.draft, state.base);
      document.body.dataset.settled = 'false';
      // What passes by is not what the page holds.
      predict({ ...question(false), shown: false });
    } else if (ended && moved) {
      adopt(next.draft, next.base);
      ask(true);
    } else if (before && next.shown.turn !== before.shown.turn && next.shown.client !== client) {
      adopt(next.draft, next.base);
      predict({ ...question(true), shown: false });
    }
  }
  showProgress(next.progress);
  if (before && ended) history.outcome(next.outcome, act);
  if (next.is_open) showLadder();
  else byId('error').textContent = '–';
}

async function run() {
  drop.listen();
  byId('fit').addEventListener('click', () => order({ kind: 'fit', ...model(), free: free() }));
  byId('score').addEventListener('click', () => order({ kind: 'score', ...model() }));
  byId('diagnose').addEventListener('click', () => order({ kind: 'diagnose' }));
  byId('keep').addEventListener('click', () => order({ kind: 'keep', ...model(), name: '' }));
  byId('cancel').addEventListener('click', () => post('api/cancel').catch((error) => trouble(error.message)));
  byId('reload').addEventListener('click', () => post('api/reload').catch((error) => warn(error.message)));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  let known = null;
  for (;;) {
    try {
      const next = await readBoard(known);
      if (next.version !== known) await follow(next);
      known = next.version;
    } catch (error) {
      trouble(error.message);
      if (error instanceof Gone) {
        document.body.dataset.gone = 'true';
        for (const button of document.querySelectorAll('button')) button.disabled = true;
      }
      await new Promise((later) => { setTimeout(later, 2000); });
    }
  }
}

run();
