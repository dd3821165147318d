// The page's one store: what the server says, what the person does, and the way between them.
import { CommandLog, randomClientId, type LoggedCommand } from './command-log';
import { Connection, type ConnectionStatus } from './connection';
import { FrameDecoder, FramePlayer, type Picture } from './frames';
import { priorityOrder } from './intervals';
import { RateMeter, Smoothed } from './meter';
import {
  emptyState,
  type Annotations,
  type Camera,
  type ColorRange,
  type DatasetEntry,
  type DatasetInfo,
  type DatasetList,
  type Frame,
  type FieldValues,
  type Histogram,
  type Interval,
  type IntervalPatch,
  type Invitation,
  type Participant,
  type Progress,
  type Role,
  type SceneState,
  type ServerEvent,
  type VolumeError,
  type Welcome,
} from './model';
import { Notices, placeOf, type Place } from './notices.svelte';
import { OptimisticState, type Overlay } from './optimistic';
import { CameraCredits, Outbox } from './pacing';
import { command, protocolMajor, type Command, type ViewportSize } from './protocol';
import { restoreStep } from './restore';
import type { SavedTab } from './saved';
import { stretched } from './transfer';
import { StreamLost } from './video-decoder';

/** A frame without its bytes, and what this side measured of it. */
export type FrameReadout = Omit<Frame, 'payload'> & { bytes: number; decodeMs: number; fps: number };

export interface SessionDoors {
  connection(handlers: {
    hello(): Command;
    onStatus(status: ConnectionStatus): void;
    onEvent(event: ServerEvent): void;
  }): Connection;
  saved: SavedTab;
  now(): number;
  schedule(callback: () => void): void;
  /** Formats for frames in motion that this browser has decoded rightly. */
  movingFormats: readonly string[];
  /** Whether the person has asked for little motion: then no cycle begins by itself. */
  calm(): boolean;
  /** Always this one of them; none: the server chooses by measured times. */
  movingFormat?: string;
  /** Whether a picture that nobody touches becomes smooth. */
  refines?: boolean;
}

const histogramBins = 256;
/** Folders and datasets of one look at the list: what the page has elements for. */
export const listedRows = 100;

export class Session {
  status = $state.raw<ConnectionStatus>({ kind: 'connecting', attempt: 0 });
  welcome = $state.raw<Welcome | null>(null);
  /** As the person sees it: the server's newest State under their own newest edits. */
  view = $state.raw<SceneState>(emptyState);
  /** Whether the server has not yet said what the person's newest edits have become. */
  waits = $state.raw(false);
  info = $state.raw<DatasetInfo | null>(null);
  /** The first of what can be opened, as far as the server has told; `listing` tells the others. */
  datasets = $state.raw<DatasetEntry[]>([]);
  /** The part of the list that is looked at; null: none is. */
  listing = $state.raw<DatasetList | null>(null);
  histogram = $state.raw<Histogram | null>(null);
  frame = $state.raw<FrameReadout | null>(null);
  /** The newest one that was shown while something changed. */
  moving = $state.raw<FrameReadout | null>(null);
  /** Set by the viewport: the finished picture is all background. */
  blank = $state(false);
  volumeErrors = $state.raw<VolumeError[]>([]);
  progress = $state.raw<Progress[]>([]);
  roundTripMs = $state.raw<number | null>(null);
  /** Everyone at the session, this page among them. */
  participants = $state.raw<Participant[]>([]);
  invitations = $state.raw<Invitation[]>([]);
  /** The invitation that was just made here, with its link; the server tells its token once. */
  made = $state.raw<Invitation | null>(null);
  role = $state.raw<Role>('controller');
  /** When the server will end, by the page's clock, and why. */
  ending = $state.raw<{ atMs: number; reason: string; comesBack: boolean } | null>(null);
  /** The layer that keys and new edits go to. */
  selected = $state.raw<number | null>(null);
  /** Of its transfer function, where it has one: the point that the swatch and the fields go to. */
  selectedPoint = $state.raw(0);
  /** A hand is at something: it is not taken away from under it, whatever the connection does. */
  interacting = $state.raw(false);
  readonly notices = new Notices();

  /** Set by the viewport. */
  drawFrame: ((picture: Picture, frame: Frame, complete: boolean) => void) | null = null;

  private server: SceneState = emptyState;
  private viewport = $state.raw<ViewportSize>({ width: 800, height: 600, hidden: false });
  private readonly connection: Connection;
  private readonly optimistic = new OptimisticState();
  private readonly credits = new CameraCredits();
  private readonly outbox: Outbox;
  private readonly player: FramePlayer;
  private readonly decoder = new FrameDecoder();
  private readonly rate = new RateMeter();
  private trip = new Smoothed();
  private readonly clientId = randomClientId();
  private readonly log = new CommandLog();
  private live = false; // welcomed on a connection that still is
  private waking = false; // the server opens the session's dataset again, and commands wait for it
  private sentAbout = new Map<number, { place: Place; interval: number | null; command: number }>();
  private cancelled = new Set<bigint>(); // operations, by this page
  private askedHistogram = '';
  private interactions = 0;
  private restoring: { saved: SceneState; opened: boolean; quiet: boolean } | null = null;
  private welcomed = false;
  private saveTimer: ReturnType<typeof setTimeout> | null = null;
  private keepsakes = new Map<number, (answer: Frame | string) => void>(); // by the message that asked
  private selectNewest = false;
  private browsing: { folder: string; search: string; first: number } | null = null;
  private relistTimer: ReturnType<typeof setTimeout> | null = null;

  constructor(private readonly doors: SessionDoors) {
    this.connection = doors.connection({
      hello: () => command.hello(this.viewport, doors.saved.session.resumeToken, doors.movingFormats, this.clientId, doors.movingFormat, doors.refines),
      onStatus: (status) => this.onStatus(status),
      onEvent: (event) => this.onEvent(event),
    });
    this.outbox = new Outbox({
      sendCamera: (camera) => {
        const seq = this.send(command.setCamera(camera));
        if (seq) this.credits.sent(seq, doors.now());
      },
      sendPatch: (id, patch) => this.send(command.patchInterval(id, patch)),
      sendOther: (_key, body) => this.send(body as Command),
      cameraMayGo: () => this.credits.open(doors.now()),
      schedule: doors.schedule,
    });
    this.player = new FramePlayer({
      decode: (frame) => this.decoder.decode(frame),
      draw: (picture, frame, complete) => this.drawFrame?.(picture, frame, complete),
      ack: (frameId, decodeMs) => {
        this.connection.send(command.frameAck(frameId, decodeMs));
        if (this.frame?.frameId === frameId) this.frame = { ...this.frame, decodeMs };
      },
      failed: (frame, problem) => {
        // Of video the server sends another stream; nobody needs to be told.
        if (problem instanceof StreamLost) this.send(command.decoderFailed(problem));
        else if (frame.streamId === 0)
          this.say(`A ${frame.format.toUpperCase()} frame of ${frame.payload.length} bytes could not be decoded: ${String(problem)}`);
      },
      now: doors.now,
    });
  }

  start(): void {
    this.connection.start();
  }
  stop(): void {
    this.connection.stop();
  }
  retryNow(): void {
    this.connection.retryNow();
  }
  /** To be called every two seconds or so. */
  heartbeat(): void {
    this.ping();
    this.connection.checkAlive();
    // States that come quickly after each other are merged by the server, so the one that an edit waits for may never come.
    if (this.live) this.settle();
    this.refresh();
  }

  // ---- what the person does ------------------------------------------------------------------------------------------------

  openDataset(id: string): void {
    this.edit({ dataset: id });
    this.notices.clear('dataset');
    this.sendInOrder(command.openDataset(id));
  }
  /** What is on the disk now, in place of what was read. */
  reloadDataset(): void {
    this.notices.clear('dataset');
    this.sendInOrder(command.reloadDataset());
  }
  /** Looks at a part of the list from now on, also when it changes; null: no more. */
  browse(what: { folder: string; search: string; first: number } | null): void {
    this.browsing = what;
    if (what) this.send(command.listDatasets(what.folder, what.search, what.first, listedRows));
    else this.listing = null;
  }
  selectArrays(change: { array?: string; colorBy?: string; texture?: string; values?: FieldValues }): void {
    // Another array is interpolated, as on the server.
    this.edit(change.array !== undefined && change.array !== this.view.array ? { values: 'interpolated', ...change } : change);
    this.notices.clear('arrays');
    this.sendInOrder(command.selectArrays(change.array ?? '', change.colorBy ?? '', change.texture ?? '', change.values ?? null));
  }
  setTime(time: number | null, timeMode: SceneState['timeMode']): void {
    this.edit(time === null ? { timeMode } : { time, timeMode });
    this.notices.clear('step');
    this.outbox.put('step', command.setTime(time, timeMode));
  }
  setCombination(terms: SceneState['terms']): void {
    this.edit({ terms });
    this.notices.clear('layers');
    this.outbox.put('terms', command.setCombination(terms));
  }
  setCycle(change: Partial<SceneState['cycle']>): void {
    // Not laid over the view: the server moves the phase on meanwhile, and its word on that is the newer one.
    this.outbox.put(`cycle ${Object.keys(change).join()}`, command.setCycle(change));
  }
  setSmear(smear: SceneState['smear']): void {
    this.edit({ smear });
    this.outbox.put('smear', command.setSmear(smear));
  }
  setStep(step: number): void {
    this.edit({ step, time: null });
    this.notices.clear('step');
    this.outbox.put('step', command.setTimeStep(step));
  }
  setClipPlanes(clipPlanes: NonNullable<SceneState['clipPlanes']>): void {
    this.edit({ clipPlanes });
    this.notices.clear('appearance');
    this.outbox.put('clipPlanes', command.setClipPlanes(clipPlanes));
  }
  setAnnotations(annotations: NonNullable<SceneState['annotations']>): void {
    this.edit({ annotations });
    this.sendInOrder(command.setAnnotations(annotations));
  }
  setOrthographic(orthographic: boolean): void {
    const { camera } = this;
    if (camera) this.moveCamera({ ...camera, orthographic });
  }
  setMode(mode: SceneState['mode']): void {
    this.edit({ mode });
    if (mode === 'cycled' && this.doors.calm()) this.setCycle({ playing: false }); // by hand, then
    this.sendInOrder(command.setAppearance({ mode }));
  }
  setColorRange(colorRange: ColorRange): void {
    this.edit({ colorRange });
    this.notices.clear('appearance');
    this.outbox.put('colorRange', command.setAppearance({ colorRange }));
  }
  setBackground(background: SceneState['background']): void {
    this.edit({ background });
    this.outbox.put('background', command.setAppearance({ background }));
  }
  setLight(light: { occlusion?: number; depthFade?: number }): void {
    this.edit(light);
    for (const field of ['occlusion', 'depthFade'] as const)
      if (light[field] !== undefined) this.outbox.put(field, command.setAppearance({ [field]: light[field] }));
  }
  setUnitDistance(unitDistance: number): void {
    this.edit({ unitDistance });
    this.outbox.put('unitDistance', command.setAppearance({ unitDistance }));
  }

  patchInterval(id: number, change: IntervalPatch): void {
    const shown = this.view.intervals.find((interval) => interval.id === id);
    if (!shown) return; // somebody has deleted it under the hand
    if (Object.entries(change).every(([field, value]) => shown[field as keyof IntervalPatch] === value)) return; // a hand at a stop
    const patch = this.withTransfer(id, change);
    this.optimistic.patch(id, patch, this.doors.now());
    this.refresh();
    this.notices.clear('layers', id);
    this.outbox.putPatch(id, patch);
  }
  // A transfer function and the layer's ends belong together: whichever is moved, the other goes along, at once and not only when the server says so.
  private withTransfer(id: number, patch: IntervalPatch): IntervalPatch {
    const before = this.view.intervals.find((interval) => interval.id === id);
    const points = patch.transfer === undefined ? before?.transfer : patch.transfer;
    const [first, last] = [points?.[0], points?.[points.length - 1]];
    if (!before || !points || !first || !last) return patch;
    if (patch.transfer) return { ...patch, lower: first.value, upper: last.value };
    if (patch.lower === undefined && patch.upper === undefined) return patch;
    const { lower, upper } = { ...before, ...patch };
    return { ...patch, lower, upper, transfer: stretched(points, lower, upper) };
  }
  addInterval(interval: Omit<Interval, 'id' | 'priority'>): void {
    const most = this.welcome?.limits.maxIntervals ?? 256;
    if (this.view.intervals.length >= most) {
      this.notices.add({ text: `The server takes at most ${most} layers.`, place: 'layers', interval: null, field: '', tone: 'error' });
      return;
    }
    const priority = this.view.intervals.reduce((top, other) => Math.max(top, other.priority), 0) + 1;
    this.selectNewest = true;
    this.notices.clear('layers');
    this.sendInOrder(command.setIntervals([...this.view.intervals, { ...interval, id: 0, priority }]));
  }
  removeInterval(id: number): void {
    this.outbox.drop(id);
    this.optimistic.remove(id, this.doors.now());
    this.notices.clear('layers', id);
    if (this.selected === id) this.selected = null;
    this.refresh();
    this.sendInOrder(command.removeInterval(id));
  }
  reorderPriorities(ids: readonly number[]): void {
    this.optimistic.reorder(ids, this.doors.now());
    this.refresh();
    this.sendInOrder(command.reorderPriorities(ids));
  }
  get priorities(): number[] {
    return priorityOrder(this.view.intervals);
  }

  /** Where the picture is seen from; null before the server has shown anything. */
  get camera(): Camera | null {
    return this.view.camera ?? this.frame?.camera ?? null;
  }
  moveCamera(camera: Camera): void {
    if (this.viewOnly) return;
    this.edit({ camera });
    this.outbox.putCamera(camera);
  }
  setView(side: string): void {
    if (this.viewOnly) return;
    this.optimistic.forget('camera');
    this.sendInOrder(command.setView(side));
  }
  beginInteraction(): void {
    this.interactions += 1;
    this.interacting = true;
    if (this.interactions === 1) this.send(command.interaction(true));
  }
  endInteraction(): void {
    if (this.interactions === 0) return;
    this.interactions -= 1;
    this.interacting = this.interactions > 0;
    this.outbox.flush();
    if (this.interactions === 0) this.send(command.interaction(false));
  }

  resizeViewport(size: { width: number; height: number }): void {
    if (size.width === this.viewport.width && size.height === this.viewport.height) return;
    this.viewport = { ...this.viewport, ...size };
    this.outbox.put('viewport', command.viewport(this.viewport));
  }
  setHidden(hidden: boolean): void {
    this.viewport = { ...this.viewport, hidden };
    this.send(command.viewport(this.viewport)); // at once: a hidden page has no animation frames
    if (!hidden) this.connection.retryNow();
  }
  get viewOnly(): boolean {
    return this.role === 'viewer';
  }
  /** Whether this page came by a link; it cannot take control by itself. */
  get invited(): boolean {
    return this.welcome?.resumeToken === '';
  }
  setRole(participant: bigint, role: Role): void {
    this.send(command.setRole(participant, role));
  }
  invite(role: Role, seconds: number, name: string): void {
    this.made = null;
    this.send(command.createInvitation(role, seconds, name));
  }
  revoke(id: string): void {
    if (this.made?.id === id) this.made = null;
    this.send(command.revokeInvitation(id));
  }
  listInvitations(): void {
    if (!this.viewOnly) this.send(command.listInvitations());
  }

  cancel(operation: bigint): void {
    this.cancelled.add(operation);
    this.send(command.cancel(operation));
  }

  /** A lossless picture for keeping, of this size and with these annotations; or why there is none. */
  keepsake(width: number, height: number, annotations: Annotations): Promise<Frame | string> {
    return new Promise((resolve) => {
      const seq = this.sendInOrder(command.requestStill(width, height, annotations));
      if (!seq) return resolve('There is no connection.');
      this.keepsakes.set(seq, resolve);
    });
  }
  /** In pixels of the device; frames in motion may have fewer. */
  get viewportSize(): { width: number; height: number } {
    return this.viewport;
  }

  say(text: string, tone: 'error' | 'note' = 'error'): void {
    this.notices.add({ text, place: 'page', interval: null, field: '', tone });
  }

  // ---- what the server says -------------------------------------------------------------------------------------------------

  private onStatus(status: ConnectionStatus): void {
    this.status = status;
    if (status.kind === 'connected') return;
    this.live = false;
    this.progress = [];
    this.cancelled.clear();
    this.sentAbout.clear();
    for (const resolve of this.keepsakes.values()) resolve('The connection was lost before the picture came.');
    this.keepsakes.clear();
    this.credits.reset();
    this.player.reset();
    this.decoder.reset();
    this.trip = new Smoothed();
    this.roundTripMs = null;
  }

  private onEvent(event: ServerEvent): void {
    switch (event.kind) {
      case 'welcome':
        return this.onWelcome(event.welcome);
      case 'state':
        return this.onState(event.state);
      case 'datasetInfo':
        this.tellSteps(event.info);
        this.info = event.info;
        this.waking = false;
        this.continueRestore();
        return this.askHistogram();
      case 'histogram':
        this.histogram = event.histogram;
        return;
      case 'frame':
        return this.onFrame(event.frame);
      case 'volumeErrors':
        this.volumeErrors = event.errors;
        return;
      case 'progress': {
        const others = this.progress.filter((p) => p.operation !== event.progress.operation);
        this.progress = [...others, event.progress];
        return;
      }
      case 'done': {
        const background = this.progress.some((p) => p.operation === event.operation && p.background);
        this.progress = this.progress.filter((p) => p.operation !== event.operation);
        const asked = this.cancelled.delete(event.operation);
        // What a newer choice has overtaken is nothing to tell: the newer one is being worked on.
        if (event.cancelled && background) {
          if (asked) this.say('Cancelled. Ranges are those of the steps that were read.', 'note');
        } else if (event.cancelled && (asked || !event.superseded)) {
          this.optimistic.forget('dataset');
          this.refresh();
          this.say('Cancelled. The picture shows the last finished state.', 'note');
        }
        return;
      }
      case 'error':
        return this.onError(event.error);
      case 'pong':
        this.roundTripMs = this.trip.add(this.doors.now() - event.clientTimeMs);
        this.log.heard(event.clientTimeMs, (body) => body.case === 'openDataset' && body.value.id !== this.server.dataset);
        return;
      case 'shutdown':
        if (event.notice) this.ending = { atMs: this.doors.now() + event.seconds * 1000, reason: event.reason, comesBack: event.comesBack };
        else this.say(`The server is shutting down${event.reason ? `: ${event.reason}` : ''}.`, 'note');
        return;
      case 'participants': {
        this.participants = event.participants;
        const me = event.participants.find((p) => p.id === this.welcome?.participant);
        if (me && me.role !== this.role) {
          this.role = me.role;
          this.optimistic.clear();
          this.refresh();
          this.say(me.role === 'viewer' ? 'You see what others show: view only.' : 'You have control.', 'note');
        }
        return;
      }
      case 'invitation':
        this.made = event.invitation;
        this.listInvitations();
        return;
      case 'invitations':
        this.invitations = event.invitations;
        return;
      case 'datasetList':
        if (this.browsing) this.listing = event.list;
        return;
      case 'datasetsChanged':
        return this.onDatasetsChanged(event.entries);
      case 'unknown':
        return;
    }
  }

  private tellSteps(info: DatasetInfo): void {
    const before = this.info;
    if (!before || before.id !== info.id || before.onDisk === 'changed' || info.times.length <= before.times.length) return;
    const more = info.times.length - before.times.length;
    this.notices.add({ text: `${more === 1 ? 'One more step has' : `${more} more steps have`} come.`, place: 'step', interval: null, field: '', tone: 'note' });
  }

  private onDatasetsChanged(entries: DatasetEntry[]): void {
    const told = new Map(entries.map((entry) => [entry.id, entry]));
    const kept = this.datasets.map((old) => told.get(old.id) ?? old);
    const added = entries.filter((entry) => !this.datasets.some((old) => old.id === entry.id));
    this.datasets = [...kept, ...added].slice(0, 1000);
    if (!this.browsing || this.relistTimer !== null) return;
    this.relistTimer = setTimeout(() => {
      this.relistTimer = null;
      if (this.browsing) this.browse(this.browsing);
    }, 100);
  }

  private onWelcome(welcome: Welcome): void {
    if (welcome.protocolMajor !== protocolMajor) {
      this.connection.refuse(
        `The server speaks version ${welcome.protocolMajor} of the protocol, this page version ${protocolMajor}: reload the page.`,
      );
      this.connection.stop();
      this.status = { kind: 'refused', reason: 'The page is of another version than the server: reload it.' };
      return;
    }
    const resumed = welcome.session !== '' && welcome.session === this.doors.saved.session.id;
    let saved = this.welcomed && this.server.dataset ? this.optimistic.view(this.server) : this.doors.saved.state;
    if (saved?.cycle && this.doors.calm()) saved = { ...saved, cycle: { ...saved.cycle, playing: false } };
    this.doors.saved.session = { id: welcome.session, resumeToken: welcome.resumeToken };
    this.welcome = welcome;
    this.datasets = welcome.datasets;
    this.role = welcome.role ?? 'controller';
    this.ending = null;
    // A guest finds the session as it is and brings nothing of their own.
    const guest = this.invited;
    const state = welcome.state ?? emptyState;
    this.askedHistogram = '';
    this.frame = null;
    this.live = true;
    this.waking = state.dataset !== '' && !welcome.datasetInfo;
    if (resumed) {
      // A restarted server describes the dataset once it has opened it again; it is the same one.
      this.info = welcome.datasetInfo ?? (this.info?.id === state.dataset ? this.info : null);
      this.optimistic.renew(this.doors.now());
    } else {
      // Ids of the old session's layers mean nothing to this one; what can be had again comes as a whole.
      this.info = welcome.datasetInfo;
      this.histogram = null;
      this.interactions = 0; // what the hand held is gone
      this.interacting = false;
      this.optimistic.clear();
      this.outbox.drop();
      this.log.clear();
      this.restoring = !guest && saved ? { saved, opened: false, quiet: !this.welcomed } : null;
    }
    this.welcomed = true;
    this.send(command.viewport(this.viewport));
    if (state.mode === 'cycled' && state.cycle.playing && this.doors.calm() && !this.viewOnly) this.setCycle({ playing: false });
    // A drag goes on under the hand that has not let go.
    if (this.interactions > 0) this.send(command.interaction(true));
    for (const logged of this.log.missing(welcome.lastCommand ?? 0)) this.transmit(logged);
    if (this.browsing) this.browse(this.browsing);
    this.ping();
    this.onState(state);
    // A session that has just begun shows something at once; one that was resumed is left as it was.
    if (!resumed && !guest) this.openFirst();
  }

  private onState(state: SceneState): void {
    const known = new Set(this.server.intervals.map((interval) => interval.id));
    const changedData = state.dataset !== this.server.dataset;
    this.server = state;
    if (changedData && this.info?.id !== state.dataset) this.info = null;
    this.settle();
    this.refresh();
    if (this.selectNewest) {
      const added = state.intervals.find((interval) => !known.has(interval.id));
      if (added) {
        this.selected = added.id;
        this.selectNewest = false;
      }
    }
    if (this.selected !== null && !state.intervals.some((interval) => interval.id === this.selected)) this.selected = null;
    this.continueRestore();
    this.askHistogram();
    this.saveSoon();
  }

  private onFrame(frame: Frame): void {
    if (frame.inReplyTo) return this.answerKeepsake(frame.inReplyTo, frame);
    this.credits.answered(frame.inputSeq);
    const { band } = frame;
    if (!band || band.index === 0) this.rate.tick(this.doors.now());
    const { payload, ...readout } = frame;
    const decodeMs = this.frame?.decodeMs ?? 0;
    if (band && band.index > 0 && this.frame) {
      // The facts came with the first band.
      const bytes = this.frame.bytes + payload.length;
      const { lossless, phase } = band.index + 1 === band.count ? frame : this.frame;
      this.frame = { ...this.frame, frameId: frame.frameId, lossless, phase, bytes };
    } else {
      const part = band && band.count > 1 ? { lossless: false, phase: 'settled' as const } : {};
      this.frame = { ...readout, ...part, bytes: payload.length, decodeMs, fps: this.rate.rate(this.doors.now()) };
      if (frame.phase === 'moving') this.moving = this.frame;
    }
    void this.player.show(frame);
  }

  private answerKeepsake(seq: number, answer: Frame | string): void {
    this.keepsakes.get(seq)?.(answer);
    this.keepsakes.delete(seq);
  }

  private onError(error: { inReplyTo: number; code: string; message: string; field: string }): void {
    // The link that this page came by is over: another try would be refused alike.
    if (error.code === 'forbidden' && !error.inReplyTo) this.connection.refuse(error.message);
    if (error.code === 'unsupported_version') this.connection.refuse(error.message);
    if (this.keepsakes.has(error.inReplyTo)) return this.answerKeepsake(error.inReplyTo, error.message || error.code);
    const { command: number, ...about } = this.sentAbout.get(error.inReplyTo) ?? { place: 'page' as Place, interval: null, command: 0 };
    if (number) this.log.refused(number);
    if (!error.inReplyTo) this.waking = false; // its dataset may have failed to open
    if (error.inReplyTo) this.optimistic.refuse(about.interval ?? undefined);
    // Of what was cancelled, Done speaks.
    if (error.code !== 'cancelled') this.notices.add({ text: error.message || error.code, ...about, field: error.field, tone: 'error' });
    if (about.place === 'histogram') this.askedHistogram = '';
    this.refresh();
  }

  // ---- between ---------------------------------------------------------------------------------------------------------------

  private edit(overlay: Overlay): void {
    this.optimistic.set(overlay, this.doors.now());
    this.refresh();
  }
  private settle(): void {
    if (this.waking) this.optimistic.renew(this.doors.now());
    this.optimistic.settle(this.server, this.doors.now());
  }
  private refresh(): void {
    this.view = this.optimistic.view(this.server);
    this.waits = this.optimistic.waits;
  }

  /** The message's seq, or 0 where it cannot go out now; what changes the session then goes out when it can. */
  private send(body: Command): number {
    if (CommandLog.keeps(body)) return this.transmit(this.log.add(body), body);
    return this.live ? this.note(this.connection.send(body), body, 0) : 0;
  }
  private transmit(logged: LoggedCommand, body = logged.body): number {
    if (!this.live) return 0;
    const seq = this.connection.send(body, logged.number);
    if (seq) logged.sentMs = this.doors.now();
    return this.note(seq, body, logged.number);
  }
  private note(seq: number, body: Command, number: number): number {
    if (seq) {
      this.sentAbout.set(seq, { ...placeOf(body), command: number });
      this.sentAbout.delete(seq - 1000);
    }
    return seq;
  }
  private ping(): void {
    this.connection.send(command.ping(this.doors.now()));
  }
  /** After everything that waits in the outbox, so that the server sees things in the order in which they were done. */
  private sendInOrder(body: Command): number {
    this.outbox.flush();
    return this.send(body);
  }

  private askHistogram(): void {
    const { dataset, step, array, values } = this.server;
    if (!dataset || !array || this.info?.id !== dataset) return;
    // Its bins span the array's range, which grows while the steps of a series are read.
    const range = this.info.arrays.find((of) => of.name === array);
    const wanted = JSON.stringify([dataset, step, array, range?.lower, range?.upper, values]);
    if (wanted === this.askedHistogram) return;
    this.askedHistogram = wanted;
    this.notices.clear('histogram');
    this.send(command.requestHistogram(array, histogramBins));
  }

  private openFirst(): void {
    const first = this.datasets.find((entry) => entry.news !== 'gone' && !entry.writing);
    if (first && !this.restoring && !this.server.dataset) this.openDataset(first.id);
  }

  private continueRestore(): void {
    const restoring = this.restoring;
    if (!restoring) return;
    const step = restoreStep(restoring.saved, this.server, this.info, this.datasets, restoring.opened, this.welcome?.datasetsAll);
    if (step.kind === 'wait') return;
    if (step.kind === 'impossible') {
      this.restoring = null;
      if (!restoring.quiet) this.say(step.reason);
      return this.openFirst();
    }
    restoring.opened = true;
    if (step.done) this.restoring = null;
    for (const body of step.commands) this.send(body);
  }

  private saveSoon(): void {
    if (this.restoring || this.saveTimer !== null) return;
    this.saveTimer = setTimeout(() => {
      this.saveTimer = null;
      if (!this.restoring && this.server.dataset) this.doors.saved.state = this.server;
    }, 300);
  }
}
