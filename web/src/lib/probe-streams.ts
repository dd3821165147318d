// One frame of each video format, with a known picture: sixteen blocks in four rows. Each is the first frame that server/encoding makes of that
// picture at 20 Mb/s; tests/encoding/probe_streams_test.cpp decodes them from this very file.

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
];
