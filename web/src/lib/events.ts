// What the server says: bytes become events. Fields that the page takes as they are stay as they come; of the others each is named here.
import { create, fromBinary } from '@bufbuild/protobuf';
import {
  FramePhase as WirePhase,
  ProbeEnd as WireEnd,
  Purpose as WirePurpose,
  ServerMessageSchema,
  StageTimesSchema,
  type Frame as WireFrame,
  type Invitation as WireInvitation,
  type ProbedCurve as WireCurve,
  type ProbeResult as WireProbe,
  type Welcome as WireWelcome,
} from '../gen/isostrata/v1/isostrata_pb';
import type { Frame, Invitation, ProbedCurve, ProbeResult, ServerEvent, Welcome } from './told';
import { names, plain, roles } from './protocol';
import { datasetInfoOf, entryOf, listOf } from './wire-datasets';
import { cameraOf, stateOf } from './wire-scene';

/** Throws if the bytes are not a ServerMessage. */
export function decodeEvent(bytes: Uint8Array): ServerEvent {
  const { body, heeded } = fromBinary(ServerMessageSchema, bytes);
  switch (body.case) {
    case 'welcome':
      return { kind: 'welcome', welcome: welcomeOf(body.value) };
    case 'state':
      return { kind: 'state', state: stateOf(body.value), heeded: Number(heeded) };
    case 'datasetInfo':
      return { kind: 'datasetInfo', info: datasetInfoOf(body.value) };
    case 'datasetList':
      return { kind: 'datasetList', list: listOf(body.value) };
    case 'datasetsChanged':
      return { kind: 'datasetsChanged', entries: body.value.entries.map(entryOf) };
    case 'histogram':
      return { kind: 'histogram', histogram: { ...body.value, counts: body.value.counts.map(Number) } };
    case 'frame':
      return { kind: 'frame', frame: frameOf(body.value) };
    case 'layerFacts':
      return {
        kind: 'volumeErrors',
        errors: body.value.intervals.flatMap(({ id, volume, volumeError: error }) => (error === undefined ? [] : [{ id, volume, error }])),
      };
    case 'probeResult':
      return { kind: 'probeResult', inReplyTo: Number(body.value.inReplyTo), result: probeOf(body.value) };
    case 'probedCurve':
      return { kind: 'probedCurve', inReplyTo: Number(body.value.inReplyTo), curve: curveOf(body.value) };
    case 'layerStatistics': {
      const { inReplyTo, revision, pieces, centroid: at, ...rest } = body.value;
      const statistics = { ...rest, revision: Number(revision), pieces: Number(pieces), centroid: [at?.x ?? 0, at?.y ?? 0, at?.z ?? 0] as const };
      return { kind: 'layerStatistics', inReplyTo: Number(inReplyTo), statistics };
    }
    case 'progress':
      return { kind: 'progress', progress: { ...plain(body.value), purpose: purposes.name(body.value.purpose) } };
    case 'done':
      return { kind: 'done', done: body.value };
    case 'error':
      return { kind: 'error', error: { ...body.value, inReplyTo: Number(body.value.inReplyTo) } };
    case 'pong':
      return { kind: 'pong', clientTimeMs: body.value.clientTimeMs };
    case 'shutdown':
      return { kind: 'shutdown', ending: body.value };
    case 'participants':
      return {
        kind: 'participants',
        participants: body.value.participants.map((who) => ({ ...who, role: roles.name(who.role) })),
        viewerSize: { width: body.value.viewerWidth, height: body.value.viewerHeight },
      };
    case 'invitation':
      return { kind: 'invitation', invitation: invitationOf(body.value) };
    case 'invitations':
      return { kind: 'invitations', invitations: body.value.invitations.map(invitationOf) };
    default:
      return { kind: 'unknown' };
  }
}

const purposes = names(WirePurpose, 'answer');
const invitationOf = (invitation: WireInvitation): Invitation => ({ ...invitation, role: roles.name(invitation.role) });

function welcomeOf({ datasets, state, datasetInfo, role, lastCommand, limits, ...rest }: WireWelcome): Welcome {
  return {
    ...rest,
    datasets: datasets.map(entryOf),
    state: state ? stateOf(state) : null,
    datasetInfo: datasetInfo ? datasetInfoOf(datasetInfo) : null,
    role: roles.name(role),
    lastCommand: Number(lastCommand),
    limits: {
      maxIntervals: limits?.maxIntervals || 256,
      maxTransferPoints: limits?.maxTransferPoints || 512,
      maxClipPlanes: limits?.maxClipPlanes || 32,
      maxWidth: limits?.maxWidth || 4096,
      maxHeight: limits?.maxHeight || 4096,
    },
  };
}

const ends: Record<WireEnd, ProbeResult['end']> = {
  [WireEnd.UNSPECIFIED]: 'domain',
  [WireEnd.LOWER]: 'lower',
  [WireEnd.UPPER]: 'upper',
  [WireEnd.DOMAIN]: 'domain',
  [WireEnd.RANGE]: 'range',
  [WireEnd.CLIP_PLANE]: 'cut',
  [WireEnd.EYE]: 'eye',
};

function probeOf({ revision, hit, miss, position, distance, interval, term, end, cell, point, cellIndex, pointIndex, step, time, arrays }: WireProbe): ProbeResult {
  return {
    revision: Number(revision),
    hit,
    miss,
    position: [position?.x ?? 0, position?.y ?? 0, position?.z ?? 0],
    distance,
    interval,
    term: term ?? null,
    end: ends[end] ?? 'domain',
    cell: cell === undefined ? null : Number(cell),
    point: point === undefined ? null : Number(point),
    cellIndex: cellIndex.map(Number),
    pointIndex: pointIndex.map(Number),
    step,
    time: time ?? null,
    arrays: arrays.map(({ name, value, cellValue }) => ({ name, value: value ?? null, cellValue: cellValue ?? null })),
  };
}

const curveOf = ({ revision, array, at, value, thinned, layers, gridsDiffer }: WireCurve): ProbedCurve => ({
  revision: Number(revision),
  array,
  at,
  values: value,
  thinned,
  gridsDiffer,
  layers: layers.map(({ from, to, interval, term }) => ({ from, to, interval, term: term ?? null })),
});

function frameOf({ revision, inputSeq, phase, stages, facts, camera, streamId, inReplyTo, band, payload, ...rest }: WireFrame): Frame {
  return {
    ...rest,
    revision: Number(revision),
    inputSeq: Number(inputSeq),
    phase: phase === WirePhase.LOSSLESS ? 'exact' : phase === WirePhase.SETTLED ? 'settled' : 'moving',
    stages: stages ?? create(StageTimesSchema),
    device: facts?.device ?? '',
    order: facts?.order ?? '',
    orderExact: facts?.orderExact ?? false,
    tetrahedra: Number(facts?.tetrahedra ?? 0n),
    pointStride: facts?.pointStride || 1,
    coarseError: facts?.coarseError ?? null,
    samples: facts?.samples || 1,
    intervals: (facts?.intervals ?? []).map((layer) => ({
      ...layer,
      activeCells: Number(layer.activeCells),
      tetrahedra: Number(layer.tetrahedra),
    })),
    camera: cameraOf(camera),
    streamId: Number(streamId),
    inReplyTo: Number(inReplyTo),
    band: band ?? null,
    payload: payload as Uint8Array<ArrayBuffer>,
  };
}
