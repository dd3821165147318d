// The page's one store, which ties its parts together: what the server says goes to the part whose business it is, and what one part learns
// of another, it learns here.
import { randomClientId } from './command-log';
import { command, type Command } from './commands';
import { Connection, type ConnectionStatus } from './connection';
import { Curves } from './curves.svelte';
import { Edits } from './edits';
import { FileList } from './file-list.svelte';
import { FrameView } from './frame-view.svelte';
import { Hand } from './hand.svelte';
import { History } from './history.svelte';
import { Smoothed } from './meter';
import { scaledBox } from './camera';
import { emptyState, type Box, type Camera, type Range, type SceneState } from './model';
import type { Ending, Frame, ServerError, ServerEvent, VolumeError, Welcome } from './told';
import { Measures } from './measures.svelte';
import { Notices } from './notices.svelte';
import { OpenDataset } from './open-dataset.svelte';
import { Outgoing } from './outgoing';
import { People } from './people.svelte';
import { Probe } from './probe.svelte';
import { protocolMajor } from './protocol';
import { Recovery } from './recovery';
import type { SavedTab } from './saved';
import { parsePlots, plotsText, type SavedPlots } from './saved-plots';
import { SceneView } from './scene-view.svelte';
import { Selection } from './selection.svelte';
import { Stills } from './stills';
import { formatRange } from './ticks';
import { Views } from './views';
import { Visits } from './visits';
import { Work } from './work.svelte';

export interface SessionDoors {
  connection(handlers: {
    hello(): Command;
    onStatus(status: ConnectionStatus): void;
    onEvent(event: ServerEvent): void;
  }): Connection;
  saved: SavedTab;
  now(): number;
  schedule(callback: () => void): void;
  after(ms: number, callback: () => void): void;
  /** Formats for frames in motion that this browser has decoded rightly. */
  movingFormats: readonly string[];
  /** Whether the person has asked for little motion: then no cycle begins by itself. */
  calm(): boolean;
  /** Always this one of them; none: the server chooses by measured times. */
  movingFormat?: string;
  /** Whether a picture that nobody touches becomes smooth. */
  refines?: boolean;
}

export class Session {
  status = $state.raw<ConnectionStatus>({ kind: 'connecting', attempt: 0 });
  welcome = $state.raw<Welcome | null>(null);
  roundTripMs = $state.raw<number | null>(null);
  volumeErrors = $state.raw<VolumeError[]>([]);
  /** When the server will end, by the page's clock, and why. */
  ending = $state.raw<{ atMs: number; reason: string; comesBack: boolean } | null>(null);

  readonly notices = new Notices();
  readonly selection = new Selection();
  readonly dataset = new OpenDataset();
  readonly scene: SceneView;
  readonly edits: Edits;
  readonly hand: Hand;
  readonly views: Views;
  readonly history: History;
  readonly frames: FrameView;
  readonly stills: Stills;
  readonly probe: Probe;
  readonly curves: Curves;
  readonly measures: Measures;
  readonly files: FileList;
  readonly people: People;
  readonly work: Work;
  readonly #connection: Connection;
  readonly #out: Outgoing;
  readonly #recovery: Recovery;
  readonly #visits: Visits;
  #trip = new Smoothed();

  constructor(private readonly doors: SessionDoors) {
    const { now, schedule, after, calm, saved } = doors;
    const clientId = randomClientId();
    this.#connection = doors.connection({
      hello: () =>
        command.hello(this.frames.viewport, this.#recovery.resumeToken, doors.movingFormats, clientId, doors.movingFormat, doors.refines),
      onStatus: (status) => this.#onStatus(status),
      onEvent: (event) => this.#onEvent(event),
    });
    const out = new Outgoing({ send: (body, number) => this.#connection.send(body, number), now, schedule });
    const send = (body: Command) => void out.send(body);
    const { notices, selection } = this;
    const scene = new SceneView(now);
    const people = new People(send);
    this.#out = out;
    this.scene = scene;
    this.people = people;
    this.history = new History({
      scene: () => scene,
      grip: () => this.hand.grip,
      now,
      bring: (plan) => this.edits.bring(plan),
      name: (id) => this.files.nameOf(id),
      leave: () => this.views.shown,
      visit: (state) => this.views.visit(state),
      say: (text) => notices.say(text, 'note'),
    });
    this.edits = new Edits(scene, out, notices, selection, people, this.history, { calm, most: () => this.welcome?.limits.maxIntervals ?? 256 });
    this.hand = new Hand(out);
    this.frames = new FrameView({
      send,
      slots: out.slots,
      acknowledge: (body) => void this.#connection.send(body),
      say: (text) => notices.say(text),
      now,
    });
    this.stills = new Stills((body) => out.sendInOrder(body));
    this.probe = new Probe((body) => out.sendInOrder(body));
    const keep = () => (saved.plots = plotsText({ dataset: scene.server.dataset, curve: this.curves.open, layers: this.measures.open }));
    this.curves = new Curves((body) => out.sendInOrder(body), keep);
    this.measures = new Measures((body) => out.sendInOrder(body), keep);
    this.files = new FileList({ send, after });
    this.work = new Work(send);
    this.#recovery = new Recovery({ saved, calm, after });
    this.#visits = new Visits(saved);
    const { edits, history, dataset, files } = this;
    this.views = new Views({
      scene, edits, history, notices, dataset, files, out,
      recovery: this.#recovery,
      visits: this.#visits,
      camera: () => this.camera,
      datasetsAll: () => this.welcome?.datasetsAll,
    });
  }

  start(): void {
    this.#connection.start();
  }
  retryNow(): void {
    this.#connection.retryNow();
  }
  setHidden(hidden: boolean): void {
    this.frames.setHidden(hidden);
    if (!hidden) this.retryNow();
  }
  /** To be called every two seconds or so. */
  heartbeat(): void {
    this.#ping();
    this.#connection.checkAlive();
    // States that come quickly after each other are merged by the server, so the one that an edit waits for may never come.
    if (this.#out.live) this.scene.settle();
  }
  /** Where the picture is seen from; null before the server has shown anything. */
  /** The dataset's, as it is drawn. */
  get box(): Box | null {
    const bounds = this.dataset.info?.bounds;
    return bounds ? scaledBox(bounds, this.scene.view.axisScale) : null;
  }
  get camera(): Camera | null {
    return this.scene.view.camera ?? this.frames.frame?.camera ?? null;
  }

  #onStatus(status: ConnectionStatus): void {
    this.status = status;
    if (status.kind === 'connected') return;
    for (const part of [this.#out, this.work, this.stills, this.probe, this.curves, this.measures, this.frames, this.history]) part.lost();
    this.#trip = new Smoothed();
    this.roundTripMs = null;
  }

  #onEvent(event: ServerEvent): void {
    switch (event.kind) {
      case 'welcome':
        return this.#onWelcome(event.welcome);
      case 'state':
        return this.#onState(event.state, event.heeded);
      case 'datasetInfo': {
        const more = this.dataset.told(event.info);
        if (more) this.notices.say(`${more === 1 ? 'One more step has' : `${more} more steps have`} come.`, 'note', 'step');
        this.scene.waking = false;
        this.#sayMoved();
        this.curves.dataTold(this.dataset.reloads, event.info.times.length);
        this.views.goOn();
        return this.askHistogram();
      }
      case 'histogram':
        return this.dataset.toldHistogram(event.histogram);
      case 'frame':
        return this.#onFrame(event.frame);
      case 'probeResult':
        this.probe.answer(event.inReplyTo, event.result);
        if (!this.curves.picking || this.probe.shown?.answer !== event.result || !event.result.hit) return;
        this.probe.close();
        return this.curves.picked(event.result.position);
      case 'layerStatistics':
        return void this.measures.answered(event.inReplyTo, event.statistics);
      case 'probedCurve':
        return void this.curves.answered(event.inReplyTo, event.curve);
      case 'volumeErrors':
        this.volumeErrors = event.errors;
        return;
      case 'progress':
        return this.work.told(event.progress);
      case 'done': {
        const cancelled = this.work.done(event.done);
        if (cancelled === 'dataset') {
          this.scene.edit((mine) => mine.forget('dataset'));
          this.#recovery.giveUp();
          this.history.stayed();
        }
        if (cancelled === 'ranges') this.notices.say('Cancelled. Ranges are those of the steps that were read.', 'note');
        else if (cancelled && cancelled !== 'answer') this.notices.say('Cancelled. The picture shows the last finished state.', 'note');
        return;
      }
      case 'error':
        return this.#onError(event.error);
      case 'pong':
        this.roundTripMs = this.#trip.add(this.doors.now() - event.clientTimeMs);
        return this.#out.heard(event.clientTimeMs, this.scene.server.dataset);
      case 'shutdown':
        return this.#onShutdown(event.ending);
      case 'participants':
        if (!this.people.told(event.participants, event.viewerSize)) return;
        this.scene.edit((mine) => mine.clear());
        return this.notices.say(this.people.viewOnly ? 'You see what others show: view only.' : 'You have control.', 'note');
      case 'invitation':
        return this.people.toldMade(event.invitation);
      case 'invitations':
        this.people.invitations = event.invitations;
        return;
      case 'datasetList':
        return this.files.told(event.list);
      case 'datasetsChanged':
        return this.files.changed(event.entries);
    }
  }

  #onWelcome(welcome: Welcome): void {
    if (welcome.protocolMajor !== protocolMajor) {
      this.#connection.stop();
      this.status = { kind: 'refused', reason: 'The page is of another version than the server: reload it.' };
      return;
    }
    const { scene, people } = this;
    const state = welcome.state ?? emptyState;
    const { steps, plots } = this.doors.saved;
    const last = this.doors.saved.state?.dataset; // of which the steps are
    const resumed = this.#recovery.welcomed(welcome, scene.server.dataset ? scene.view : null);
    this.welcome = welcome;
    this.ending = null;
    people.welcomed(welcome);
    this.files.welcomed(welcome.datasets);
    this.dataset.welcomed(welcome.datasetInfo, state.dataset, resumed);
    this.frames.welcomed();
    this.#out.welcomed(resumed);
    scene.waking = state.dataset !== '' && !welcome.datasetInfo;
    // Ids of an old session's layers mean nothing to a new one, and what the hand held is gone.
    scene.edit((mine, nowMs) => (resumed ? mine.renew(nowMs) : mine.clear()));
    if (!resumed) {
      this.hand.empty();
      this.history.clear();
      this.doors.saved.steps = '';
      this.measures.clear();
      this.doors.saved.plots = '';
    }
    this.frames.tellViewport();
    if (state.mode === 'cycled' && state.cycle.playing && this.doors.calm() && !people.viewOnly) this.edits.setCycle({ playing: false });
    this.hand.goesOn();
    this.#out.resend(welcome.lastCommand ?? 0);
    this.files.askAgain();
    this.#ping();
    this.#onState(state, -1);
    if (resumed) this.#visits.arrived(null);
    if (resumed && state.dataset === last) this.history.restore(steps);
    if (resumed) this.#restorePlots(parsePlots(plots));
    // A session that has just begun shows something at once; one that was resumed is left as it was.
    if (!resumed && !people.invited) this.views.openFirst();
  }

  #restorePlots(plots: SavedPlots | null): void {
    const { server } = this.scene;
    if (!plots || plots.dataset !== server.dataset) return;
    this.curves.dataTold(this.dataset.reloads, this.dataset.info?.times.length ?? 0);
    if (plots.curve) this.curves.restore(plots.curve);
    this.measures.restore(server, plots.layers, this.dataset.reloads);
  }

  /** Layers keep their ends when their files are read anew: over other values these may say nothing. */
  #sayMoved(): void {
    const { array, intervals } = this.scene.view;
    const was = this.dataset.rangeBefore(array);
    const is = this.dataset.info?.arrays.find(({ name }) => name === array);
    if (!was || !is || !intervals.length) return;
    const words = (range: Range) => formatRange(range.lower, range.upper).join(' … ');
    const run = () => this.edits.fitLayers(was, is);
    this.notices.say(`The values were ${words(was)} and are ${words(is)} now. The layers keep their ends.`, 'note', 'layers', { label: 'Fit layers to the new values', run });
  }

  /** heeded: up to which of this connection's messages. */
  #onState(state: SceneState, heeded: number): void {
    const before = this.scene.server;
    if (state.dataset !== before.dataset) {
      const ours = !before.dataset || this.scene.view.dataset === state.dataset || this.#recovery.active;
      if (!ours) this.notices.say(`Somebody else has opened “${this.files.nameOf(state.dataset)}”.`, 'note');
      this.views.turns(before.dataset, state);
      this.dataset.turnedTo(state.dataset);
      this.history.turned(state.dataset);
      this.measures.clear();
    }
    this.scene.told(state);
    this.history.told(heeded);
    this.selection.told(before.intervals, state.intervals);
    this.probe.stateTold(state.revision);
    this.curves.told(state);
    this.views.goOn();
    this.askHistogram();
    this.#recovery.keep(state, () => this.history.text());
  }

  #onFrame(frame: Frame): void {
    if (frame.inReplyTo) return void this.stills.answer(frame.inReplyTo, frame);
    this.#out.answered(frame.inputSeq);
    this.frames.told(frame);
  }

  #onShutdown({ notice, seconds, reason, comesBack }: Ending): void {
    if (notice) this.ending = { atMs: this.doors.now() + seconds * 1000, reason, comesBack };
    else this.notices.say(`The server is shutting down${reason ? `: ${reason}` : ''}.`, 'note');
  }

  #onError({ inReplyTo, code, message, field }: ServerError): void {
    // The link that this page came by is over: another try would be refused alike.
    if ((code === 'forbidden' && !inReplyTo) || code === 'unsupported_version') this.#connection.refuse(message);
    const why = code === 'cancelled' ? 'Cancelled.' : message || code;
    if (this.stills.answer(inReplyTo, why) || this.probe.answer(inReplyTo, why) || this.curves.answered(inReplyTo, why) || this.measures.answered(inReplyTo, why)) return;
    const about = this.#out.refused(inReplyTo);
    if (this.#out.overtaken(inReplyTo)) return; // the dataset that was chosen since is on its way
    if (about.place === 'histogram') return this.dataset.refused(inReplyTo, why, code === 'cancelled');
    if (inReplyTo) this.scene.edit((mine) => mine.refuse(about.interval ?? undefined));
    else this.scene.waking = false; // its dataset may have failed to open
    if (inReplyTo) this.history.told(inReplyTo);
    // Of a picture and a dataset that were cancelled, Done speaks.
    if (code !== 'cancelled') this.notices.add({ text: why, ...about, field, tone: 'error' });
    if (about.place === 'dataset') this.views.failed();
  }

  #ping(): void {
    this.#connection.send(command.ping(this.doors.now()));
  }
  /** Of what is shown, unless it has been asked for. */
  askHistogram(again = false): void {
    const wanted = this.dataset.wants(this.scene.server, again);
    if (wanted) this.dataset.sent(this.#out.send(wanted));
  }
}
