// One frame of each video format, with a known picture: sixteen blocks in four rows. Each is the first frame that server/encoding makes of that
// picture at 20 Mb/s (H.264 without x264's comment); tests/encoding/probe_streams_test.cpp decodes them from this very file.

export interface ProbeStream {
  format: string; // in Hello and Frame
  codec: string; // of VideoDecoderConfig
  fullChroma: boolean;
  base64: string;
}

export const probeSide = 64;

/** The blocks' colours, row by row. */
export const probeColors: readonly (readonly [number, number, number])[] = [
  [255, 0, 0],
  [0, 255, 0],
  [0, 0, 255],
  [255, 255, 255],
  [0, 0, 0],
  [255, 255, 0],
  [0, 255, 255],
  [255, 0, 255],
  [128, 128, 128],
  [200, 30, 60],
  [30, 200, 60],
  [60, 30, 200],
  [17, 17, 17],
  [240, 240, 240],
  [255, 128, 0],
  [64, 0, 128],
];

export const probeStreams: readonly ProbeStream[] = [
  {
    format: 'vp9-444',
    codec: 'vp09.01.10.08.03.01.13.06.00',
    fullChroma: true,
    base64:
      'okmDQiAAfgB+gIcEg4MEAABKR9j9+D7xH0eMfseJ/+C+gw0/vf4r/0/kaI9R/eT1fFfPGEaQAHniamhbjBTIlBvXBW+yI4HyhMQJzOm5TVvWsSWARcH7eEhVdKZ9UWbohWtMJaTOxIFzMunCBKlJu/I9eJDqbR62G3YVIN/G4HUjtVCEk1sDfswEUQuRwB5g5hkac3tUoTzD0H3c6DeNGzw55XKrwK7jUWVDTysj7MtiHjfY4wjWNeZ7daT8wxKB5cr8/sdPTA5hjTTGtDKQgwgo4tozfWi5ksHAF0ek78oHOV99043QEnSkWAHhhQYuHjq2nvL60GKNCxdN8mNb6xMAUDhsLzEF3P76YhGKs4u82kqNxN0WEOXwYZgP7o2N9BXcFLM+QgepC1yyjyZ2u9dp7kDWqehNdrOvM/3rFHxW7OekfPiODJM4w2ByE9kNgeVdNRze/wPSR7nKqtB8WG37qpc+KVI2lbal4C9AjD+QBBsnadz8fmlZgA==',
  },
  {
    format: 'h264-420',
    codec: 'avc1.64001f',
    fullChroma: false,
    base64:
      'AAAAAWdkACCstCE01AQ0GQAAAwABAAADADyPGDKgAAAAAWjvPLAAAAABZYiEBr/s/8JV/wKO/ah/9UUXakjsXoaVv9HfOoUbJI1almApBzRPE27dZ7yWAScrc1AbQfdGHdnMRb7uUp/nIiYSdobYPNBzE99Hh/8ABX2NpWX2ak9ZmtzSvgJVFSA1dmleVYpN0ZaUWDKY9F2A3XNrAvrLoma8qjEzUQfHLX70LQAtBsEz7mPlma5ibeWfIBImA3r6YQ0t1qKpXKIUvGS+f2vj6GmtodJG6Z9x29CK+xuPmpPKHDWIx6M3ouHYkASvyxPDtU7Jg+Imsisqi1OCTSh3uA4IDJ4J08z5qoc/WxYqQ15++VpaKnOW6fhtqVdRFv6KYtLOLs4DG6qWewzYtxkVt8rrd3ZYRHtxj5FqGfJ0ddAO3ulv/WhobDtxx+cBdxcJuXYKqxoEgdhF66tsvXU2jj0G2FdnNZ359m10ySg5PMTkk5rkRUd5WkgClUEkiTmWCvdrqXw2VtghZBcf2YmUc8wOoseG4CzL0X7jI0A1vD7x5G+59bLovgJsm66mFvanPjvn',
  },
];
