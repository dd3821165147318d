// The port with TLS: pages, API and WebSocket behind one certificate.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { connect } from 'node:tls';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { Server } from './server';

const token = 'a-token-that-is-long-enough-for-a-test-0123456789';
const folder = mkdtempSync(join(tmpdir(), 'isostrata-tls-'));
const certificate = join(folder, 'certificate.pem');
const key = join(folder, 'key.pem');
let server: Server;

beforeAll(async () => {
  const subject = ['-subj', '/CN=localhost', '-addext', 'subjectAltName=DNS:localhost,IP:127.0.0.1'];
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ed25519', '-nodes', '-days', '2', '-keyout', key, '-out', certificate, ...subject], { stdio: 'pipe' });
  server = await Server.start({ data: ['sphere:16'], token, more: ['--device', 'native', '--tls-cert', certificate, '--tls-key', key] });
});
afterAll(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** One request over TLS; what came back until the server closed, or the head of an upgrade. */
function ask(request: string): Promise<string> {
  return new Promise((done, failed) => {
    const socket = connect({ port: server.ready.port, host: '127.0.0.1', servername: 'localhost', ca: readFileSync(certificate) });
    let text = '';
    socket.on('error', failed);
    socket.on('data', (bytes) => {
      text += bytes.toString('latin1');
      if (!text.startsWith('HTTP/1.1 101') || !text.includes('\r\n\r\n')) return;
      done(text);
      socket.destroy();
    });
    socket.on('end', () => done(text));
    socket.write(request);
  });
}
const head = `Host: localhost\r\nAuthorization: Bearer ${token}\r\n`;

test('requests and large answers pass, and the cookie is for https alone', async () => {
  expect(server.ready.url).toMatch(/^https:/);
  expect(await ask(`GET /api/v1/datasets HTTP/1.1\r\n${head}Connection: close\r\n\r\n`)).toMatch(/^HTTP\/1.1 200[\s\S]*sphere-16/);
  expect(await ask(`GET /?token=${token} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n`)).toMatch(/Set-Cookie: .*; Secure/);
  const curl = ['--silent', '--fail', '--cacert', certificate, '-H', `Authorization: Bearer ${token}`];
  const url = `https://localhost:${server.ready.port}/api/v1/openapi.json`;
  expect(JSON.parse(execFileSync('curl', [...curl, url], { encoding: 'utf8' })).openapi).toBe('3.1.0');
});

test('the WebSocket opens behind it', async () => {
  const upgrade = 'Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n';
  expect(await ask(`GET /ws HTTP/1.1\r\n${head}${upgrade}Sec-WebSocket-Protocol: isostrata.v1\r\n\r\n`)).toMatch(/^HTTP\/1.1 101/);
});

test('who does not speak TLS gets no answer, and others are served', async () => {
  const plain = await fetch(`http://127.0.0.1:${server.ready.port}/healthz`).catch(() => null);
  expect(plain).toBeNull();
  expect(await ask(`GET /healthz HTTP/1.1\r\n${head}Connection: close\r\n\r\n`)).toMatch(/^HTTP\/1.1 200/);
});

test('files that are no certificate are named', async () => {
  const start = (more: string[]) => Server.start({ data: ['sphere:16'], token, more });
  await expect(start(['--tls-cert', key, '--tls-key', key])).rejects.toThrow(/key\.pem: no certificate in PEM/);
  await expect(start(['--tls-cert', certificate, '--tls-key', certificate])).rejects.toThrow(/certificate\.pem: no key/);
  await expect(start(['--tls-cert', certificate])).rejects.toThrow(/belong together/);
});
