// The access token: it comes in the address once, is taken out of sight, and is kept for this tab so that it can reconnect.

const key = 'isostrata.token';

export interface TokenDoors {
  location: { href: string };
  storage: Pick<Storage, 'getItem' | 'setItem'>;
  replaceUrl(url: string): void;
}

/** The token of this tab, empty if there is none. A token in the address replaces a stored one and leaves the address bar. */
export function takeToken(doors: TokenDoors): string {
  const url = new URL(doors.location.href);
  const given = url.searchParams.get('token');
  if (given === null) return read(doors.storage);
  url.searchParams.delete('token');
  doors.replaceUrl(url.href);
  try {
    doors.storage.setItem(key, given);
  } catch {
    // Storage can be forbidden; the token then lives as long as the page.
  }
  return given;
}

function read(storage: TokenDoors['storage']): string {
  try {
    return storage.getItem(key) ?? '';
  } catch {
    return '';
  }
}

/** The WebSocket beside the page, wherever the page is mounted. */
export function socketUrl(pageUrl: string, token: string): string {
  const url = new URL('ws', pageUrl);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  url.hash = '';
  url.search = token ? `?token=${encodeURIComponent(token)}` : '';
  return url.href;
}
