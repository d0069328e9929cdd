// Switches and sliders. They read and write the draft; what follows from it is up to the caller.

const STEPS = 1000;

const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

export const short = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(3) : String(Number(value.toPrecision(5)));
};

const toStep = (c, value) => {
  if (c.log && c.min > 0) return STEPS * Math.log(value / c.min) / Math.log(c.max / c.min);
  return STEPS * (value - c.min) / (c.max - c.min);
};
const fromStep = (c, step) => {
  const share = step / STEPS;
  if (share <= 0) return c.min;
  if (share >= 1) return c.max;
  return c.log && c.min > 0 ? c.min * (c.max / c.min) ** share : c.min + share * (c.max - c.min);
};

let made = 0;

/** One slider with its number, bounds and the tick that gives it to the fit. `read` and `write` reach the draft. */
function slider(c, title, read, write, free) {
  const id = `slider-${made += 1}`;
  const range = element('input', { type: 'range', id, min: 0, max: STEPS, step: 1 });
  const number = element('input', { type: 'number', step: 'any', min: c.min, max: c.max });
  number.setAttribute('aria-label', `${c.name}, value`);
  range.dataset.name = c.name;
  const show = () => {
    const value = read() ?? c.usual;
    range.value = toStep(c, value);
    range.setAttribute('aria-valuetext', `${short(value)} ${c.unit}`);
    number.value = Number(value.toPrecision(6));
    number.setCustomValidity('');
  };
  range.addEventListener('input', () => { write(fromStep(c, Number(range.value))); show(); });
  number.addEventListener('change', () => {
    const value = Number(number.value);
    if (number.value === '' || !(value >= c.min && value <= c.max)) {
      number.setCustomValidity(`${c.name} lies between ${short(c.min)} and ${short(c.max)} ${c.unit}`);
      number.reportValidity();
      return;
    }
    write(value);
    show();
  });
  const label = element('label', { htmlFor: id, title: c.description }, title);
  const row = element('div', { className: 'row' }, range, number, element('span', {}, c.unit === '1' ? '' : c.unit));
  const bounds = element('span', { className: 'bounds' }, `${short(c.min)} to ${short(c.max)}${c.own ? ', this run' : ''}`);
  const box = element('div', { className: 'slider' }, label, row, bounds);
  if (free) {
    const tick = element('input', { type: 'checkbox', checked: !free.held.has(c.name) });
    tick.addEventListener('change', () => {
      if (tick.checked) free.held.delete(c.name); else free.held.add(c.name);
    });
    bounds.append(' ', element('label', {}, tick, ' fit'));
    tick.setAttribute('aria-label', `fit ${c.name}`);
  }
  show();
  return { box, show };
}

/** Builds all controls into the page; returns a function that shows the draft in them. */
export function build(controls, state, changed) {
  const shows = [];
  const values = (c) => {
    if (!c.own) return state.draft.shared;
    return state.draft.own[state.runName()] ??= {};
  };
  const make = (c, title) => {
    const one = slider(c, title, () => values(c)[c.name], (v) => { values(c)[c.name] = v; changed(); }, state);
    shows.push(one.show);
    return one.box;
  };
  document.getElementById('nuisances').replaceChildren(...controls.nuisances.map((c) => make(c, c.name)));
  const setting = (effect, c) => {
    const read = () => state.draft.effects[effect.id]?.[c.name];
    const write = (v) => { (state.draft.effects[effect.id] ??= {})[c.name] = v; changed(); };
    const one = slider({ ...c, usual: c.usual }, c.description || c.name, read, write, null);
    shows.push(one.show);
    return one.box;
  };
  const one = (effect) => {
    const box = element('div', { className: 'effect' });
    box.dataset.words = `${effect.id} ${effect.title}`.toLowerCase();
    const tick = element('input', { type: 'checkbox', id: `effect-${effect.id}` });
    const formula = element('p', { className: 'formula', id: `formula-${effect.id}` },
      element('code', {}, effect.equation), element('br'), effect.description);
    const label = element('label', { htmlFor: tick.id, title: effect.equation }, ` ${effect.title} `,
      element('span', { className: 'bounds' }, effect.id));
    tick.setAttribute('aria-describedby', formula.id);
    const inner = element('div');
    box.append(tick, label, formula, inner);
    let built = false;
    const show = () => {
      const on = effect.id in state.draft.effects;
      tick.checked = on;
      box.classList.toggle('on', on);
      inner.hidden = !on;
      if (on && !built) {
        built = true;
        inner.append(...effect.parameters.map((c) => make(c, `${c.description || c.name}`)),
          ...effect.settings.map((c) => setting(effect, c)));
        if (effect.nodes) inner.append(element('p', { className: 'bounds' }, `${effect.nodes} values along the belt: found by Fit.`));
      }
    };
    tick.addEventListener('change', () => {
      if (tick.checked) state.draft.effects[effect.id] = {};
      else delete state.draft.effects[effect.id];
      show();
      changed(true);
    });
    shows.push(show);
    return box;
  };
  const own = controls.effects.filter((e) => !e.library);
  const library = controls.effects.filter((e) => e.library);
  const host = document.getElementById('effects');
  host.replaceChildren(...own.map(one));
  const box = element('details', { id: 'library' }, element('summary', {}, `Library: ${library.length} terms`), ...library.map(one));
  if (library.length) host.append(box);
  const filter = document.getElementById('filter');
  filter.oninput = () => {
    const word = filter.value.trim().toLowerCase();
    for (const effect of host.querySelectorAll('.effect')) effect.hidden = !effect.dataset.words.includes(word);
    if (word) box.open = true;
  };
  const showAll = () => {
    for (const show of [...shows]) show();
    if (library.some((e) => e.id in state.draft.effects)) box.open = true;
  };
  showAll();
  return showAll;
}

export { element };
