// A frame of VP9 4:4:4 with a known picture: sixteen blocks in four rows, whose edges lie at odd pixels, so that halved chroma shows. It is the
// first frame that server/encoding makes of that picture at 20 Mb/s; tests/encoding/probe_stream_test.cpp decodes it from this very file.

export interface ProbeStream {
  format: string; // in Hello and Frame
  codec: string; // of VideoDecoderConfig
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

/** Blocks begin at 0, 17, 33 and 49. */
const blockOf = (at: number): number => Math.max(0, Math.floor((at - 1) / 16));

export const probeColor = (x: number, y: number) => probeColors[4 * blockOf(y) + blockOf(x)] as readonly [number, number, number];

/** Whether no other block is nearer than four pixels. */
export const insideBlock = (x: number, y: number): boolean =>
  [x, y].every((at) => blockOf(Math.max(0, at - 4)) === blockOf(Math.min(probeSide - 1, at + 4)));

export const probeStream: ProbeStream = {
  format: 'vp9-444',
  codec: 'vp09.01.10.08.03.01.13.06.00',
  base64:
    'okmDQiAAfgB+gIcEg4MEAAB6X2P43/9+o/480f8J9FvFzzH6P4OIuNMUNfWv/w9a/5DrXDnPWv5n43/OZqMHL+Z+Z8bKviitH8WPuFIAAHnlf//3aEhtzlgmRbaXwdT8X8bu9NTpFVFHeX9ii+SVc9OX////+0+b/////6ilD2Bb4burh/YzfROGJ2Iu2i2uwjaXM2ktB/U991pLy0H2QwL8vWmyN/y9abI3qN6M++MjuW6/goefR/kn3yhwd6IrjZyxgRLlmf3QGkbBtUsABViw7Ju2lKsYd/n7FDWHe6g33QGkbcei4xe48YjStIr2cqFNH0MefFxx9DHnxbvlBbf9MM984mUkwqStif9km4REt5x7/0v+6IL9f/0KofFYsGWUtth5DI84AxZ7yiWEzoyFaCsPLAHq06ZaurB9p+wj6WdtJqCDJybRDZzv8m6omLn5pSI80sQl7zau6CqcrZ7KDq6OBFzCcf+6IL/BjdlcMnOASlWkjDyn+ZjvmmA/tlUa7n9wcdIpI5AonOwi+mnyySNJKWdz0xyO/BroN0TPVGwjSZcAPAH8F2YOn//TSevkw5xg9uxqoWVidGFCP40MZBVCF0cCLmE4vM2+G4cZm9SPDGbwJfd0WXDan5LQ0i5hOP/dEF/gxuyuGTnAJSrSRh5T/Mx3zTDB39PtVrlh/whh09kvN/scLlO0nxCT2yf2zozveR3LaZUyOE+NUDxbSUN1JFvA/ckDxXdYa6aEK2ch4A9hQtBGDf/w3zPcHIDp5+mR4fi9EbO8DNEv2nAj4qriEOJIkAA2BNahT3bvY8t272Q71O86bWx066I4ZFPepLyg1B01TqSVMHtTCr/+cVtbl3zT0w+zsa3+Ve7hWSm0UGqIfn//vl0YtOmIOGMDB2UbopEMb+Lb/4IPDSSbAKApFX5eFg73zNEC+E3NCJnQotyVdNo7nS1CE38S/FLUppOPtSmkvZOlkZ0l66aLg7JKrkXmzpxhVxqYBnvSlep0AOqA0f/v4H/wEE1sCapaVY63cdpx4h+P+fK4NJARs+iBHqyMl8LQcua+us59JaKobq1tH13pchKr9M3EAweRQMdmsUp4VMeY419odg2OthuA2OMXO3FfSpWRjdcgkNaAPmCNkTfs/Jt94RVCZ3ODF5r+tvWoOG2MYWSuQirB9s8vHAt+wxY2smOhWN+/QlnYunI6mLKuc29xhqQBwYK5BK7c54WykIxHACdqEJjT7pZ/yw0DhQEyxv+kItvwX148sIj/ysQxsiSfcs+jdmhj84Yz6CwA0jEOYmJy7RuDAO64W7+2fSKlxjNn945Fompy//SJl3ZbGB0f5stey92KgLNKL86iGE7nv/HZ8KyoP5CPXuyqyzFwnTbN0pR8ptL1Zy8jb9Z/NwCA3JTKB0e2qS53KSZA8fIrghPN3kWH1zI6NVK0HNjCNgq+R3FoJrsb1iNUqgNFIfrusRBIRnkBtJS0ZGeybZhpT7+jjVRpWjkox2cAe9+fRYI049MKvFDrfv9A6aBUE+lWM4yez2hmfqAeMXnC0o2y5vC8R1I0glipY+w66JzY/fmQo1Umk1sWM/W+SZMpqNDNIP6qrPyu5sJF+NxFUKmWCpQFadOLOX2FuLBY7VvJqstvSYjnXoKpUBwa8eNAW8apdB5CCB5M+re2dp3nHZHSGvPZRlozsPs3/U4CibdNklK0azRie1jEZyJ1K4Fl7DSpFPvXkKTPW31zUpGjO0F5HxIPRZhLHbTVeQrtk7d1LRD+x8CW0uSEGtUPupOHkp6xdlfkY8Lz4x5UwkGZMqauV0CvjsNKkWGGZOmijzeeXeRZv35dSh6wBZELOdyw9Y9THj/xNq+wM9lxlT/743B5dTnnrM4FW3uFKNYhM8mSxw+zf421lWIJGLHpgGsXPgMSn3qW3ROmNs+mKakijW5fzv/hNstjDAcUBskTOSyELaLJoXSO+C1ZUue0k+tntJPqlYA=',
};
