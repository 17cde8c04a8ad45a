/* Pictures of a simulation of palpate.h, drawn off-screen with OpenGL: a library of its own, because palpate.h needs
 * neither OpenGL nor EGL. C99. */
#ifndef PALPATE_IMAGE_H
#define PALPATE_IMAGE_H

#include "palpate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Looks at a target from a distance, with +z up. */
typedef struct palpate_camera {
  uint32_t size;        /* sizeof(palpate_camera) */
  uint32_t reserved;    /* 0 */
  double target[3];     /* m */
  double distance;      /* m, 0 .. 1e6 */
  double azimuth_deg;   /* of the eye around +z, from +x */
  double elevation_deg; /* of the eye above the horizon, -90 .. 90 */
  double fov_deg;       /* vertical, 0 .. 180 */
} palpate_camera;

/* The scene's own camera. */
PALPATE_API int32_t palpate_scene_camera(const palpate_simulation *simulation, palpate_camera *camera);

/* (viewer) Draws the newest tick. The first call of a thread, and one after a call for another model, takes longer: it
 * makes an OpenGL context and the buffers, which the thread keeps. No context may be current on the calling thread
 * but that one. PALPATE_REFUSED in a process that was forked off after a first picture.
 * @param camera  NULL: the scene's
 * @param rgba    (height, width, 4) 8-bit sRGB, upper row first, alpha 255 */
PALPATE_API int32_t palpate_image(palpate_simulation *simulation, const palpate_camera *camera, uint8_t *rgba,
                                  int32_t width, int32_t height, palpate_error *error);

#ifdef __cplusplus
}
#endif

#endif
