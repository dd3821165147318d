/* What the program and its optional module libisostrata_avcodec.so say to each other. The module is apart because libavcodec may bring x264,
 * which is under the GPL: the program does not link either, and looks for the module when it starts (avcodec_module.h).
 *
 * Every function is called by one thread at a time for one handle. Where one fails it returns 0 (a null pointer) and leaves one line in
 * `error`, which has room for ISOSTRATA_AVCODEC_ERROR bytes. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ISOSTRATA_AVCODEC_ABI = 1, ISOSTRATA_AVCODEC_ERROR = 256 };

/* Planes of 4:2:0: Y has even width and height, Cb and Cr half of each. */
struct isostrata_planes {
  const uint8_t* plane[3];
  ptrdiff_t stride[3];
  int width, height; /* of Y */
};

struct isostrata_packet {
  const uint8_t* data; /* Annex B; valid until the next call */
  size_t size;
  int key;
};

struct isostrata_avcodec {
  int abi;             /* ISOSTRATA_AVCODEC_ABI */
  const char* library; /* "libavcodec 59.37.100" */
  /* `encoder` by libavcodec's name: "h264_nvenc", "h264_vaapi", "libx264", "libopenh264". */
  void* (*open_encoder)(const char* encoder, int width, int height, double frames_per_second, int kbps, int threads, char* error);
  /* One frame in, its packet out. The colour is BT.601's matrix in the limited range; the bitstream says so. */
  int (*encode)(void* encoder, const struct isostrata_planes* picture, int kbps, int key, struct isostrata_packet* packet, char* error);
  void (*close_encoder)(void* encoder);
  /* For measuring. */
  void* (*open_decoder)(char* error);
  int (*decode)(void* decoder, const uint8_t* data, size_t size, struct isostrata_planes* picture, char* error);
  void (*close_decoder)(void* decoder);
};

/* The module's one symbol. */
__attribute__((visibility("default")))
const struct isostrata_avcodec* isostrata_avcodec_module(void);

#ifdef __cplusplus
}
#endif
