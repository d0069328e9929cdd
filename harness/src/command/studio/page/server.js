// What the page asks of the server. Every failure becomes an Error whose text is fit to be shown.

export const client = crypto.randomUUID();

const GONE = 'The server is gone. Start "stickslip studio" with the same -o again and open the address that it prints: ' +
  'the tries are kept there.';

/** A server that no longer answers. */
export class Gone extends Error {
  constructor() { super(GONE); }
}

async function answer(promise) {
  let response;
  try { response = await promise; } catch { throw new Gone(); }
  const text = await response.text();
  let value = null;
  try { value = JSON.parse(text); } catch { /* an error of the server is plain text */ }
  if (!response.ok) {
    throw new Error(value && value.error ? value.error : text || `the server answered ${response.status}`);
  }
  return value;
}

export const get = (path) => answer(fetch(path, { headers: { accept: 'application/json' } }));

export const post = (path, body = {}) => answer(fetch(path, {
  method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body),
}));

export const sendFile = (file) => answer(fetch(`api/file?name=${encodeURIComponent(file.name)}`, {
  method: 'POST', headers: { 'content-type': 'application/octet-stream' }, body: file,
}));

export const board = (since) =>
  get(`api/board?client=${client}${since === null ? '' : `&since=${since}`}`);

/**
 * Asks for predictions one at a time: while one is on its way only the newest question waits, so that a slider that moves never
 * fills a queue. `use` is told whether the answer is to the newest question.
 */
export function latest(use, fail) {
  let busy = false;
  let next = null;
  const send = async (question) => {
    busy = true;
    const begun = performance.now();
    try {
      const found = await post('api/predict', question);
      if (found) use(found, question, begun, next === null);
    } catch (error) { fail(error); }
    busy = false;
    if (next) { const waiting = next; next = null; send(waiting); }
  };
  return (question) => {
    if (busy) next = question; else send(question);
  };
}
