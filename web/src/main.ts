// Wires the page: token, connection, store, and the one component that holds the others.
import { mount } from 'svelte';
import App from './App.svelte';
import './style.css';
import { calm } from './lib/calm';
import { Connection, type NotOpened, type Socket } from './lib/connection';
import { MadeFile } from './lib/made-file.svelte';
import { browserProbe, probeDecoders } from './lib/probe-decoders';
import { saveBlob } from './lib/save-blob';
import { SavedTab } from './lib/saved';
import { Session } from './lib/session.svelte';
import { ThemeChoice } from './lib/theme.svelte';
import { Thumbnails } from './lib/thumbnails';
import { socketUrl, takeToken } from './lib/token';

const theme = new ThemeChoice();
const token = takeToken({
  location,
  storage: sessionStorage,
  replaceUrl: (url) => history.replaceState(history.state, '', url),
});

/** An address of the API, with the token. */
function apiUrl(path: string): URL {
  const url = new URL(`api/v1/${path}`, document.baseURI);
  if (token) url.searchParams.set('token', token);
  return url;
}

const thumbnails = new Thumbnails({
  ask: (dataset, signal) => fetch(apiUrl(`datasets/${encodeURIComponent(dataset)}/thumbnail`), { signal }),
  urlOf: (picture) => URL.createObjectURL(picture),
  forget: (url) => URL.revokeObjectURL(url),
});

const made = () =>
  new MadeFile({
    ask: (path, method, body, signal) => fetch(apiUrl(path), { method, ...(signal ? { signal } : {}), ...(body ? { body, headers: { 'Content-Type': 'application/json' } } : {}) }),
    save: saveBlob,
    wait: (ms) => new Promise((done) => setTimeout(done, ms)),
  });

/** A refused handshake looks like a dead server to a page; plain HTTP tells the two apart. */
async function askWhy(): Promise<NotOpened> {
  try {
    const response = await fetch(apiUrl('datasets'), { cache: 'no-store', signal: AbortSignal.timeout(5000) });
    if (response.status === 401)
      return {
        kind: 'refused',
        reason: 'The server does not accept this access token. Open the address that the server printed when it was started: it carries the right one.',
      };
    if (response.status === 403) {
      const problem = (await response.json().catch(() => ({}))) as { detail?: string; title?: string };
      // An invitation opens the socket and not the API: it is good, and the socket will open when the server has room.
      if (problem.detail?.startsWith('an invitation')) return { kind: 'unknown' };
      return { kind: 'refused', reason: problem.detail ?? problem.title ?? 'The server does not let this page in.' };
    }
    return { kind: response.status >= 502 && response.status <= 504 ? 'unreachable' : 'unknown' };
  } catch {
    return { kind: 'unreachable' };
  }
}

/** Nothing is awaited outside of a function, or what comes on demand could not share this file. */
async function start(): Promise<void> {
  // Some tens of milliseconds, before Hello says what came of it.
  const movingFormats = await probeDecoders(browserProbe());

  // For trying one out: ?codec=vp9-444 in the page's address. For comparing pictures: ?samples=1 holds on to one sample a pixel.
  const wanted = new URL(location.href).searchParams;
  const wantedFormat = wanted.get('codec') ?? '';

  const session = new Session({
    connection: (handlers) =>
      new Connection({
        ...handlers,
        open: (subprotocol) => new WebSocket(socketUrl(document.baseURI, token), subprotocol) as Socket,
        askWhy,
        now: () => performance.now(),
        setTimeout: (callback, ms) => window.setTimeout(callback, ms),
        clearTimeout: (id) => window.clearTimeout(id),
        random: Math.random,
      }),
    saved: new SavedTab(sessionStorage, location.pathname),
    now: () => performance.now(),
    schedule: (callback) => void requestAnimationFrame(callback),
    after: (ms, callback) => void setTimeout(callback, ms),
    movingFormats,
    calm,
    movingFormat: movingFormats.includes(wantedFormat) ? wantedFormat : '',
    refines: wanted.get('samples') !== '1',
  });

  mount(App, { target: document.getElementById('app') as HTMLElement, props: { session, theme, thumbnails, exports: made(), films: made() } });
  if (document.hidden) session.setHidden(true); // opened in a background tab
  session.start();
  setInterval(() => session.heartbeat(), 2000);
  document.addEventListener('visibilitychange', () => session.setHidden(document.hidden));
  window.addEventListener('online', () => session.retryNow());
}
void start();
