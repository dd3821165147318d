// The REST API as its own document describes it, on a real server: the document is linted, every operation in it is called and its
// answers are held against its schemas; the curl lines of docs/scripts.md are run; a browser watches what scripts do.
import { createConfig, lint as lintDocument } from '@redocly/openapi-core';
import { Ajv2020, type ValidateFunction } from 'ajv/dist/2020';
import type { Browser } from 'playwright-core';
import { execFile } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { promisify } from 'node:util';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { repository, Server } from './server';
import { launch, Viewer } from './viewer';

type Json = any; // eslint-disable-line @typescript-eslint/no-explicit-any

const token = 'a-token-that-is-long-enough-for-a-test-0123456789';
let server: Server;
let base = '';
let document: Json;

beforeAll(async () => {
  server = await Server.start({ data: ['torus:64', 'sphere:16', 'cylinder:8x8x4x3'], token, more: ['--device', 'native', '--log-format', 'json'] });
  base = `http://127.0.0.1:${server.ready.port}`;
  document = await (await call('GET', '/openapi.json')).json();
});
afterAll(async () => {
  await server?.stop();
});

function call(method: string, path: string, body?: Json, headers: Record<string, string> = {}): Promise<Response> {
  const json: Record<string, string> = body === undefined ? {} : { 'Content-Type': 'application/json' };
  return fetch(`${base}/api/v1${path}`, {
    method,
    headers: { Authorization: `Bearer ${token}`, ...json, ...headers },
    ...(body === undefined ? {} : { body: JSON.stringify(body) }),
  });
}

async function lint(text: string): Promise<string[]> {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-openapi-'));
  try {
    const file = join(folder, 'openapi.json');
    writeFileSync(file, text);
    const config = await createConfig({ extends: ['recommended-strict'] });
    return (await lintDocument({ ref: file, config })).map((p) => `${p.ruleId}: ${p.message}`);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

test('a linter accepts the OpenAPI document, and would say so if it did not', async () => {
  expect(await lint(JSON.stringify(document))).toEqual([]);
  const broken = structuredClone(document);
  delete broken.paths['/datasets'].get.operationId;
  broken.paths['/sessions'].post.requestBody.content['application/json'].schema.$ref = '#/components/schemas/Nowhere';
  expect((await lint(JSON.stringify(broken))).length).toBeGreaterThanOrEqual(2);
});

/** Validates answers by the document alone; every object has the members that its schema names, and no other. */
class Answers {
  private readonly ajv = new Ajv2020({ strict: false, allErrors: true });
  private readonly compiled = new Map<string, ValidateFunction>();
  readonly called = new Set<string>();

  constructor() {
    const strict = structuredClone(document.components);
    for (const schema of Object.values<Json>(strict.schemas)) close(schema);
    this.ajv.addSchema({ $id: 'openapi', components: strict });
  }
  private schema(name: string): ValidateFunction {
    const known = this.compiled.get(name) ?? this.ajv.compile({ $ref: `openapi#/components/schemas/${name}` });
    this.compiled.set(name, known);
    return known;
  }
  /** Calls an operation by its id, checks its status against the list of its answers, and its body against the schema. */
  async call(id: string, path: Record<string, string> = {}, body?: Json, query = '', headers = {}): Promise<{ response: Response; json: Json; text: string }> {
    const [template, method, operation] = this.find(id);
    const target = template.replace(/\{(\w+)\}/g, (_, name: string) => path[name] ?? `{${name}}`);
    const response = await call(method.toUpperCase(), target + query, body, headers);
    const text = await response.text();
    const kind = response.status < 400 ? String(response.status) : `${String(response.status)[0]}XX`;
    let described = operation.responses[kind];
    expect(described, `${id} answered ${response.status}, which the document does not know: ${text}`).toBeDefined();
    if (described.$ref) described = document.components.responses.Problem;
    const type = (response.headers.get('content-type') ?? '').split(';')[0] as string;
    if (described.content) expect(Object.keys(described.content), id).toContain(type);
    else expect(text, id).toBe('');
    let json: Json = null;
    const reference: string | undefined = described.content?.[type]?.schema?.$ref;
    if (reference) {
      json = JSON.parse(text);
      const validate = this.schema(reference.split('/').pop() as string);
      expect(validate(json), `${id}: ${JSON.stringify(validate.errors)} in ${text.slice(0, 500)}`).toBe(true);
    }
    if (response.status < 400) this.called.add(id);
    return { response, json, text };
  }
  private find(id: string): [string, string, Json] {
    for (const [path, methods] of Object.entries<Json>(document.paths))
      for (const [method, operation] of Object.entries<Json>(methods)) if (operation.operationId === id) return [path, method, operation];
    throw new Error(`the document has no operation ${id}`);
  }
}
function close(schema: Json): void {
  if (schema.properties && schema.additionalProperties === undefined) schema.additionalProperties = false;
  for (const value of Object.values<Json>(schema)) if (value && typeof value === 'object') close(value);
}

test('every operation of the document can be called, and answers what the document says', async () => {
  const answers = new Answers();
  const dataset = 'torus-64';
  for (const id of ['getDescription', 'getVersion', 'getHealth', 'listColorMaps', 'listDatasets']) await answers.call(id);
  for (const id of ['getDataset', 'listArrays', 'getDatasetHistogram', 'getDatasetStatistics']) await answers.call(id, { dataset });
  const picture = (await answers.call('getThumbnail', { dataset })).response.headers.get('etag') as string;
  expect((await answers.call('getThumbnail', { dataset }, undefined, '', { 'If-None-Match': picture })).response.status).toBe(304);
  const session = (await answers.call('createSession', {}, { dataset })).json.id as string;
  const at = { session };
  const happened = answers.call('watchSession', at);
  await answers.call('listSessions');
  for (const id of ['getSession', 'getSessionDataset', 'getHistogram', 'getStatistics', 'getLayers', 'listOperations']) await answers.call(id, at);

  await answers.call('putTransferFunction', at, {
    points: [
      { value: 0, color: { r: 1 }, opacity: 0.1 },
      { value: 0.5, color: { b: 1 }, opacity: 0.9 },
    ],
  });
  await answers.call('putIntervals', at, { intervals: [{ lower: 0, upper: 0.1, visible: true, opacity: 0.5, surface: { upper: true } }] });
  const added = (await answers.call('addInterval', at, { lower: 0.2, upper: 0.3, opacityUpper: 0.9 })).json;
  const interval = String(added.intervals.at(-1).id);
  await answers.call('getInterval', { session, interval });
  await answers.call('patchInterval', { session, interval }, { upper: 0.25 });
  await answers.call('putClipPlanes', at, { clipPlanes: [{ normal: { x: 1 }, offset: -5 }] });
  await answers.call('putCombination', at, { terms: [{ op: 'RANGE_OPERATOR_INTERSECT', array: 'distance', lower: 0, upper: 1 }] });
  await answers.call('putView', at, { view: '+x' });
  const probed = (await answers.call('getProbe', at, undefined, '?x=0.5&y=0.5&width=400&height=300')).json;
  expect(probed.arrays.map(({ name }: Json) => name)).toEqual(['distance']);
  expect((await answers.call('getProbe', at, undefined, '?x=0&y=0')).json.miss).toContain('background');
  expect((await answers.call('getProbe', at)).response.status).toBe(400);
  // From outside the box, which begins after 1.
  const line = (await answers.call('getProbeLine', at, undefined, '?from=-2,0.1,0.2&to=0.9,0.1,0.2')).json;
  expect(line.at[0]).toBeCloseTo(1);
  expect(line.value).toHaveLength(line.at.length);
  expect((await answers.call('getProbeLine', at, undefined, '?from=0,0,0')).response.status).toBe(400);
  expect((await answers.call('getProbeSteps', at, undefined, '?at=0.5,0.1,0.2')).text).toContain('has one step');
  const series = (await answers.call('createSession', {}, { dataset: 'cylinder-8x8x4x3' })).json.id as string;
  expect((await answers.call('getProbeSteps', { session: series }, undefined, '?at=2,0.5,4')).json.value).toHaveLength(3);
  await answers.call('deleteSession', { session: series });
  expect((await answers.call('getIntervalStatistics', { session, interval })).json.volume).toBeGreaterThan(0);
  // Each part of the state is read, and given back.
  for (const part of Object.keys(document.paths).filter((p) => document.paths[p].get?.tags[0] === 'scene')) {
    const { get, put, patch } = document.paths[part];
    const { json } = await answers.call(get.operationId, at);
    await answers.call((put ?? patch).operationId, at, json);
  }
  await answers.call('deleteInterval', { session, interval });
  await answers.call('doCommand', at, { setView: { view: 'reset' } });
  const state = (await answers.call('getState', at)).json;
  await answers.call('patchState', at, { unitDistance: 0.5 });
  await answers.call('putState', at, state);
  for (const format of ['png', 'jpeg', 'webp', 'exr']) await answers.call('getImage', at, undefined, `?width=32&height=24&format=${format}`);
  await answers.call('getImage', at, undefined, '?width=32&height=24&transparent=true');
  expect((await answers.call('getImage', at, undefined, '?format=jpeg&transparent=true')).response.status).toBe(400);
  const tag = (await answers.call('getImage', at)).response.headers.get('etag') as string;
  expect((await answers.call('getImage', at, undefined, '', { 'If-None-Match': tag })).response.status).toBe(304);

  expect((await answers.call('openDataset', at, { id: 'sphere-16' }, '', { Prefer: 'respond-async' })).response.status).toBe(202);
  await answers.call('openDataset', at, { id: 'sphere-16' });
  for (const format of ['vtu', 'ply', 'stl']) {
    const operation = (await answers.call('createExport', at, { format })).json.id as string;
    const events = (await answers.call('watchOperation', { session, operation })).text;
    expect(events).toMatch(/event: done\n/);
    expect((await answers.call('getOperation', { session, operation })).json.status).toBe('done');
    await answers.call('getExport', { session, export: operation });
    if (format === 'vtu') await answers.call('deleteOperation', { session, operation });
    else await answers.call('deleteExport', { session, export: operation });
  }
  const film = (await answers.call('createFilm', at, { turnDeg: 90, seconds: 0.2, width: 64, height: 48 })).json.id as string;
  expect((await answers.call('watchOperation', { session, operation: film })).text).toMatch(/event: done\n/);
  await answers.call('getFilm', { session, film });
  await answers.call('deleteFilm', { session, film });
  await answers.call('getEngine');
  await answers.call('listParticipants', at);
  await answers.call('putViewerSize', at, { width: 640, height: 360 });
  expect((await answers.call('listParticipants', at)).json.viewerWidth).toBe(640);
  expect((await answers.call('putViewerSize', at, { width: 640 })).text).toContain('the size is 640x0; expected 64x64 to 16384x16384');
  await answers.call('createInvitation', at, { role: 'ROLE_VIEWER', seconds: 3600 });
  const invitation = (await answers.call('listInvitations', at)).json.invitations[0].id as string;
  await answers.call('revokeInvitation', { session, invitation });
  // Refusals have a schema, too.
  for (const [id, path, body] of [
    ['getState', { session: 'nosuch' }, undefined],
    ['getInterval', { session, interval: '77' }, undefined],
    ['putCamera', at, { fovDeg: 'x' }],
    ['putView', at, { view: '?' }],
    ['createExport', at, { format: 'obj' }],
    ['createFilm', at, {}],
  ] as [string, Record<string, string>, Json][])
    expect((await answers.call(id, path, body)).response.status).toBeGreaterThanOrEqual(400);
  await answers.call('deleteSession', at);
  const events = (await happened).text;
  for (const event of ['state', 'change', 'participants', 'operation', 'ended']) expect(events).toContain(`event: ${event}\ndata: {`);

  const described = Object.values<Json>(document.paths).flatMap((methods) => Object.values<Json>(methods).map((o) => o.operationId as string));
  expect([...answers.called].sort()).toEqual(described.sort());
});

test('the curl lines of docs/scripts.md do what they say', async () => {
  const page = readFileSync(join(repository, 'docs/scripts.md'), 'utf8');
  const block = page.match(/```sh\nURL=.*TOKEN=.*\n([\s\S]*?)```/);
  expect(block, 'there are no curl lines').not.toBeNull();
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-curl-'));
  try {
    const { stdout } = await promisify(execFile)('bash', ['-euo', 'pipefail', '-c', block?.[1] as string], {
      cwd: folder,
      env: { ...process.env, URL: base, TOKEN: token },
    });
    expect(stdout).toMatch(/^torus-64$/m);
    expect(stdout).toMatch(/event: done/);
    expect(readFileSync(join(folder, 'events.txt'), 'utf8')).toMatch(/^event: state\n[\s\S]*\nevent: change\n[\s\S]*\nevent: ended\n/);
    expect(stdout.trim().split('\n').pop()).toBe('{"lower":0.1,"upper":0.2,"opacity":0.8}');
    expect(readFileSync(join(folder, 'layers.png')).subarray(1, 4).toString()).toBe('PNG');
    expect(readFileSync(join(folder, 'layers.vtu')).subarray(0, 5).toString()).toBe('<?xml');
    expect(existsSync(join(folder, 'saved.json'))).toBe(true);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

test('probes and metrics tell of what was done, and every line of the log names its session and request', async () => {
  expect((await fetch(`${base}/readyz`)).status).toBe(200);
  expect((await fetch(`${base}/metrics`)).status).toBe(401);
  await call('GET', '/sessions/nosuch/state', undefined, { 'X-Request-Id': 'a-test.7' });
  const metrics = await (await fetch(`${base}/metrics`, { headers: { Authorization: `Bearer ${token}` } })).text();
  expect(metrics).toMatch(/^isostrata_frames_total\{format="png",phase="still"\} [1-9]/m);
  expect(metrics).toMatch(/^isostrata_stage_seconds_bucket\{stage="draw",le="\+Inf"\} [1-9]/m);
  expect(metrics).toMatch(/^isostrata_http_requests_total\{method="GET",route="\/sessions\/\{session\}\/state",status="404"\} [1-9]/m);
  const lines = server.log.split('\n').filter((line) => line.startsWith('{'));
  const parsed = lines.map((line) => JSON.parse(line) as Json);
  for (const line of parsed)
    expect(Object.keys(line)).toEqual(expect.arrayContaining(['time_ms', 'level', 'event', 'message', 'session', 'request']));
  expect(parsed).toContainEqual(expect.objectContaining({ event: 'request', session: 'nosuch', request: 'a-test.7', status: 404 }));
  expect(server.log.replace(/Open .*/, '')).not.toContain(token);
});

test('a browser sees the interval that curl moves', async () => {
  let browser: Browser | null = null;
  try {
    browser = await launch();
    const viewer = await Viewer.open(browser, server.ready.url);
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const before = await viewer.exactPicture();
    const path = `/sessions/${viewer.sessionId}/intervals/${viewer.state.intervals[0]?.id}`;
    await promisify(execFile)('curl', ['-sS', '--fail', '-X', 'PATCH', '-H', `Authorization: Bearer ${token}`, '--json', '{"lower": 0.05, "upper": 0.125}', `${base}/api/v1${path}`]);
    await viewer.until('the moved interval', (state) => state.intervals[0]?.upper === 0.125);
    expect((await viewer.exactPicture()).pixels).not.toEqual(before.pixels);
    expect(viewer.problems).toEqual([]);
  } finally {
    await browser?.close();
  }
});
