// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
'use strict';
/*
 * A small viewer of points and surfaces in WebGL2: one context, one object at a time.
 *
 * Camera: the object turns about `target`, which lies `distance` before the eye. `turn` is the
 * rotation from the object to the eye (rows, x right, y up, z towards the viewer).
 */

const FIELD = 24 * Math.PI / 180;  // of view, top to bottom
const NONE = 65535;                // no view, no residual (report_pack.py)
const MODES = {plain: 0, view: 1, residual: 2, rgb: 3, state: 4, pick: 9};
// Blue - pale yellow - red (ColorBrewer RdYlBu): safe for the colour-blind, grey stays for 'none'.
const SCALE = [[49, 54, 149], [116, 173, 209], [255, 255, 191], [244, 109, 67], [165, 0, 38]];
const STATES = [[140, 140, 148], [44, 150, 120], [200, 0, 200]];  // alone, confirmed, contradicted
const FILLED = [[214, 202, 232], [126, 96, 168]];  // stripes where no view saw a surface

const inShader = (colours) => colours.map(
  (c) => `vec3(${c.map((v) => (v / 255).toFixed(4)).join(',')})`).join(',');

const VERTEX_SHADER = `#version 300 es
precision highp float;
precision highp int;
in vec3 position; in vec2 normal; in vec3 rgb; in float view; in float residual; in float state;
uniform mat4 toEye, toScreen;
uniform float edge; uniform vec3 origin;
uniform float limit, pixels; uniform int mode, mesh, tinted;
uniform sampler2D views;
out vec3 eye, eyeNormal, paint;
out float value, known;
flat out vec4 viewPaint; flat out int id, kind;

vec3 unfold(vec2 square) {  // octahedral normal, Cigolle et al. 2014
  vec2 f = square / 127.0 - 1.0;
  vec3 n = vec3(f, 1.0 - abs(f.x) - abs(f.y));
  float t = max(-n.z, 0.0);
  n.xy += vec2(n.x >= 0.0 ? -t : t, n.y >= 0.0 ? -t : t);
  return normalize(n);
}

void main() {
  vec4 at = toEye * vec4(position * edge + origin, 1.0);
  eye = at.xyz;
  eyeNormal = normal.x > 254.5 ? vec3(0.0) : mat3(toEye) * unfold(normal);
  paint = rgb;
  known = residual < 65534.5 ? 1.0 : 0.0;
  value = (residual / 4095.0 - 1.0) * limit;
  kind = int(state + 0.5);
  id = gl_VertexID;
  viewPaint = vec4(0.6, 0.6, 0.6, 1.0);
  if (tinted == 1 && view < 65534.5) viewPaint = texelFetch(views, ivec2(int(view + 0.5), 0), 0);
  gl_Position = toScreen * at;
  gl_PointSize = clamp(pixels / -at.z, 1.5, 48.0);
  if (mesh == 0 && viewPaint.a < 0.9) gl_Position.z += 0.006 * gl_Position.w;  // behind the one picked
  if (mesh == 0 && viewPaint.a < 0.2) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // hidden
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
precision highp int;
in vec3 eye, eyeNormal, paint;
in float value, known;
flat in vec4 viewPaint; flat in int id, kind;
uniform int mode, mesh, filled;
uniform float range, stripe;
uniform vec3 plain, back;
out vec4 colour;

vec3 onScale(float t) {  // -1 to 1
  const vec3 stops[5] = vec3[5](${inShader(SCALE)});
  float at = clamp(t * 2.0 + 2.0, 0.0, 4.0);
  int low = min(int(at), 3);
  return mix(stops[low], stops[low + 1], at - float(low));
}

void main() {
  const vec3 stripes[2] = vec3[2](${inShader(FILLED)});
  const vec3 states[3] = vec3[3](${inShader(STATES)});
  if (mode == 9) {
    int k = id + 1;
    colour = vec4(k & 255, (k >> 8) & 255, (k >> 16) & 255, 1 + filled) / 255.0;
    return;
  }
  if (mesh == 0 && length(gl_PointCoord - 0.5) > 0.56) discard;
  vec3 base = plain;
  if (mode == 1) base = viewPaint.rgb;
  if (mode == 2) base = known > 0.999 ? onScale(value / range) : states[0];
  if (mode == 2 && kind == 2) base = states[2];
  if (mode == 3) base = paint;
  if (mode == 4) base = states[clamp(kind, 0, 2)];
  if (filled == 1) {
    base = stripes[int(mod((gl_FragCoord.x + gl_FragCoord.y) / stripe, 2.0))];
  }
  vec3 n = eyeNormal;
  if (mesh == 1 && dot(n, n) < 0.01) n = cross(dFdx(eye), dFdy(eye));
  float facing = dot(n, n) < 0.01 ? 0.75 : dot(normalize(n), normalize(-eye));
  if (mesh == 1) {
    facing = abs(facing);
    if (!gl_FrontFacing) base = mix(base, back, 0.75);
  } else if (facing < 0.0) {
    base = mix(base, back, 0.6);  // a point seen from behind
    facing = -facing;
  }
  vec3 lit = base * (0.38 + 0.62 * facing);
  if (viewPaint.a < 0.9) lit = mix(lit, back, 0.82);  // of a view that is not picked out
  colour = vec4(lit, 1.0);
}`;

const sharpness = () => Math.min(window.devicePixelRatio || 1, 2);
const rotation = (axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  if (axis === 0) return [1, 0, 0, 0, c, -s, 0, s, c];
  if (axis === 1) return [c, 0, s, 0, 1, 0, -s, 0, c];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
};
const product = (a, b) => a.map((_, k) => {
  const row = k - k % 3, col = k % 3;
  return a[row] * b[col] + a[row + 1] * b[col + 3] + a[row + 2] * b[col + 6];
});
const turned = (m, v) => [0, 3, 6].map((r) => m[r] * v[0] + m[r + 1] * v[1] + m[r + 2] * v[2]);
const turnedBack = (m, v) => [0, 1, 2].map((c) => m[c] * v[0] + m[c + 3] * v[1] + m[c + 6] * v[2]);

class Viewer {
  /** @param canvas element; `changed` is called after each drawing. Throws without WebGL2. */
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed;
    this.gl = canvas.getContext('webgl2', {antialias: true, alpha: false});
    if (!this.gl) throw new Error('no WebGL2');
    this.object = null;
    this.state = {layer: '', colour: 'plain', range: 1, arrow: true};
    this.colours = {background: [1, 1, 1], plain: [0.7, 0.7, 0.7], back: [0.5, 0.5, 0.5],
                    arrow: [0.8, 0.2, 0.5]};
    this.tint = new Uint8Array([153, 153, 153, 255]);
    this.build();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => { this.build(); this.upload(); });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  build() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX_SHADER],
                                [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, 'position');
    gl.linkProgram(program);
    this.program = program;
    this.at = {};
    for (const name of ['toEye', 'toScreen', 'edge', 'origin', 'limit', 'pixels', 'mode', 'mesh',
                        'filled', 'stripe', 'tinted', 'views', 'range', 'plain', 'back']) {
      this.at[name] = gl.getUniformLocation(program, name);
    }
    this.texture = gl.createTexture();
    this.drawn = {};
    gl.enable(gl.DEPTH_TEST);
  }

  /** Show another object; the buffers of the one before are given back. */
  load(object) {
    this.release();
    this.object = object;
    for (const layer of Object.values(object.layers)) {
      if (layer.arrays) continue;
      layer.arrays = {};
      for (const [name, Kind, columns, steps] of [
        ['position', Uint16Array, 3, true], ['normal', Uint8Array, 2, true],
        ['rgb', Uint8Array, 3, true], ['view', Uint16Array, 1, false],
        ['residual', Uint16Array, 1, false], ['state', Uint8Array, 1, false]]) {
        if (layer[name]) {
          layer.arrays[name] = unpacked(layer[name], Kind, layer.count, columns, steps);
        }
      }
      if (layer.faces) layer.arrays.faces = unpackedFaces(layer.faces, layer.triangles);
    }
    this.upload();
    this.reset();
  }

  release() {
    const gl = this.gl;
    for (const part of Object.values(this.drawn)) {
      gl.deleteVertexArray(part.array);
      part.buffers.forEach((buffer) => gl.deleteBuffer(buffer));
    }
    this.drawn = {};
    if (this.object) Object.values(this.object.layers).forEach((layer) => { delete layer.arrays; });
  }

  upload() {
    if (!this.object) return;
    for (const [name, layer] of Object.entries(this.object.layers)) {
      this.drawn[name] = this.part(layer.arrays);
    }
    this.drawn.arrow = this.part({position: arrowShape(), count: 0});
    this.retint(this.tint);
  }

  /** Return the buffers of a layer: what it lacks takes a value that says so. */
  part(arrays) {
    const gl = this.gl, array = gl.createVertexArray(), buffers = [];
    const put = (target, data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      buffers.push(buffer);
    };
    gl.bindVertexArray(array);
    for (const [name, width, normalized] of [
      ['position', 3, true], ['normal', 2, false], ['rgb', 3, true], ['view', 1, false],
      ['residual', 1, false], ['state', 1, false]]) {
      const at = gl.getAttribLocation(this.program, name), data = arrays[name];
      if (at < 0 || !data) continue;
      put(gl.ARRAY_BUFFER, data);
      const kind = data instanceof Float32Array ? gl.FLOAT
        : data instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_BYTE;
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, width, kind, normalized, 0, 0);
    }
    if (arrays.faces) put(gl.ELEMENT_ARRAY_BUFFER, arrays.faces);
    gl.bindVertexArray(null);
    const count = arrays.faces ? arrays.faces.length : arrays.position.length / 3;
    return {array, buffers, count, mesh: Boolean(arrays.faces)};
  }

  /** Colours of the views, four bytes each; the last is 255 shown, 128 faded, 0 hidden. */
  retint(bytes) {
    const gl = this.gl;
    this.tint = bytes;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, bytes.length / 4, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE,
                  bytes);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    this.redraw();
  }

  set(changes) {
    Object.assign(this.state, changes);
    this.redraw();
  }

  reset() {
    const {centre, radius, flip, arrow} = this.object;
    this.target = [...centre];
    // The arrow lies within, however the object is turned.
    const reach = arrow && this.state.arrow ? Math.max(arrow.tip + ARROW.long, 1.05) : 1.05;
    this.distance = 1.06 * reach * radius / Math.sin(FIELD / 2);
    const upright = flip ? [1, 0, 0, 0, -1, 0, 0, 0, -1] : [1, 0, 0, 0, 1, 0, 0, 0, 1];
    this.turn = product(rotation(0, 0.3), product(rotation(1, -0.45), upright));
    this.fit();
    this.redraw();
  }

  fit() {  // into a canvas that is higher than wide
    const {clientWidth: w, clientHeight: h} = this.canvas;
    if (w && h && w < h) this.distance *= h / w;
  }

  rotate(right, down, clockwise = 0) {
    const step = product(rotation(2, -clockwise), product(rotation(0, down), rotation(1, right)));
    this.turn = product(step, this.turn);
    this.redraw();
  }

  /** Look along a direction of the object's frame, `from` pointing from the object to the eye. */
  lookFrom(from) {
    const size = Math.hypot(...from), z = from.map((v) => v / size);
    const up = turnedBack(this.turn, [0, 1, 0]);
    let x = [up[1] * z[2] - up[2] * z[1], up[2] * z[0] - up[0] * z[2], up[0] * z[1] - up[1] * z[0]];
    if (Math.hypot(...x) < 1e-3) x = turnedBack(this.turn, [1, 0, 0]);
    const width = Math.hypot(...x);
    x = x.map((v) => v / width);
    const y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    this.turn = [...x, ...y, ...z];
    this.redraw();
  }

  /** Move what is shown, in CSS pixels. */
  pan(right, down) {
    const unit = this.unit();
    const back = turnedBack(this.turn, [right * unit, -down * unit, 0]);
    this.target = this.target.map((v, k) => v - back[k]);
    this.redraw();
  }

  /** Come nearer (factor below 1) to what is at a place, in CSS pixels from the middle. */
  zoom(factor, x = 0, y = 0) {
    const {radius} = this.object, before = this.unit();
    this.distance = Math.min(Math.max(this.distance * factor, radius * 0.05), radius * 60);
    const gain = before - this.unit();
    const step = turnedBack(this.turn, [x * gain, -y * gain, 0]);
    this.target = this.target.map((v, k) => v + step[k]);
    this.redraw();
  }

  /** Length of a CSS pixel at the target, in the object's units. */
  unit() {
    return 2 * Math.tan(FIELD / 2) * this.distance / Math.max(this.canvas.clientHeight, 1);
  }

  redraw() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => { this.waits = false; this.draw(); this.changed(); });
  }

  matrices(width, height) {
    const {turn: r, target, object} = this, move = turned(r, target);
    const reach = 3 * object.radius + Math.hypot(...target.map((v, k) => v - object.centre[k]));
    const near = Math.max(this.distance - reach, this.distance * 0.02);
    const far = this.distance + reach, f = 1 / Math.tan(FIELD / 2);
    return {
      toEye: [r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0,
              -move[0], -move[1], -move[2] - this.distance, 1],
      toScreen: [f * height / width, 0, 0, 0, 0, f, 0, 0,
                 0, 0, -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0],
    };
  }

  /** Where a point of the object is on the canvas, in CSS pixels. */
  project(point) {
    const {clientWidth: w, clientHeight: h} = this.canvas;
    const eye = turned(this.turn, point.map((v, k) => v - this.target[k]));
    const scale = h / 2 / Math.tan(FIELD / 2) / (this.distance - eye[2]);
    return [w / 2 + eye[0] * scale, h / 2 - eye[1] * scale, eye[2]];
  }

  draw() {
    const {gl, canvas} = this, sharp = sharpness();
    const width = Math.round(canvas.clientWidth * sharp);
    const height = Math.round(canvas.clientHeight * sharp);
    if (!this.object || !width || !height) return;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.clearColor(...this.colours.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawLayer(width, height, MODES[this.state.colour]);
    if (this.state.arrow && this.object.arrow) this.drawArrow(width, height);
  }

  use(width, height, mode) {
    const {gl, at, object} = this, {toEye, toScreen} = this.matrices(width, height);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(at.toEye, false, toEye);
    gl.uniformMatrix4fv(at.toScreen, false, toScreen);
    gl.uniform1i(at.mode, mode);
    gl.uniform3fv(at.plain, this.colours.plain);
    gl.uniform3fv(at.back, this.colours.back);
    gl.uniform1f(at.edge, object.edge);
    gl.uniform3fv(at.origin, object.origin);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.uniform1i(at.views, 0);
    for (const [name, values] of [['normal', [255, 255]], ['rgb', [0.6, 0.6, 0.6]],
                                  ['view', [NONE]], ['residual', [NONE]], ['state', [0]]]) {
      const place = gl.getAttribLocation(this.program, name);
      if (place >= 0) gl[`vertexAttrib${values.length}f`](place, ...values);
    }
  }

  drawLayer(width, height, mode) {
    const {gl, at} = this, layer = this.object.layers[this.state.layer];
    const part = this.drawn[this.state.layer];
    if (!layer || !part) return;
    this.use(width, height, mode);
    gl.uniform1i(at.mesh, part.mesh ? 1 : 0);
    gl.uniform1i(at.tinted, layer.view ? 1 : 0);
    gl.uniform1f(at.limit, layer.limit || 1);
    gl.uniform1f(at.range, this.state.range);
    gl.uniform1f(at.pixels, 2.0 * layer.spacing * height / (2 * Math.tan(FIELD / 2)));
    gl.bindVertexArray(part.array);
    gl.uniform1f(at.stripe, 4 * sharpness());
    if (part.mesh) {
      const known = part.count - 3 * (layer.filled || 0);
      gl.drawElements(gl.TRIANGLES, known, gl.UNSIGNED_INT, 0);
      gl.uniform1i(at.filled, 1);
      gl.drawElements(gl.TRIANGLES, part.count - known, gl.UNSIGNED_INT, 4 * known);
      gl.uniform1i(at.filled, 0);
    }
    else gl.drawArrays(gl.POINTS, 0, part.count);
    gl.bindVertexArray(null);
  }

  /** Draw the arrow that stands where the sensor should, and points at the object. */
  drawArrow(width, height) {
    const {gl, at, object} = this, z = object.arrow.direction, part = this.drawn.arrow;
    this.use(width, height, MODES.plain);
    gl.uniform3fv(at.plain, this.colours.arrow);
    gl.uniform3fv(at.back, this.colours.arrow);
    gl.uniform1i(at.mesh, 1);
    gl.uniform1i(at.tinted, 0);
    gl.uniform1f(at.edge, 1);
    gl.uniform3fv(at.origin, [0, 0, 0]);
    const a = Math.abs(z[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0];
    let x = [a[1] * z[2] - a[2] * z[1], a[2] * z[0] - a[0] * z[2], a[0] * z[1] - a[1] * z[0]];
    x = x.map((v) => v / Math.hypot(...x));
    const y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    const {toEye} = this.matrices(width, height), s = object.radius;
    const c = object.centre.map((v, k) => v + object.arrow.tip * s * z[k]);
    const own = [...x.map((v) => v * s), 0, ...y.map((v) => v * s), 0, ...z.map((v) => v * s), 0,
                 ...c, 1];
    const both = new Float32Array(16);
    for (let col = 0; col < 4; col++) {
      for (let row = 0; row < 4; row++) {
        for (let k = 0; k < 4; k++) both[4 * col + row] += toEye[4 * k + row] * own[4 * col + k];
      }
    }
    gl.uniformMatrix4fv(at.toEye, false, both);
    gl.bindVertexArray(part.array);
    gl.drawArrays(gl.TRIANGLES, 0, part.count);
    gl.bindVertexArray(null);
  }

  /** Where the arrow begins and ends, on the canvas in CSS pixels; null without an arrow. */
  arrowEnds() {
    const {arrow, centre, radius} = this.object;
    if (!this.state.arrow || !arrow) return null;
    return [ARROW.long, 0].map((along) => this.project(
      centre.map((v, k) => v + arrow.direction[k] * radius * (arrow.tip + along))));
  }

  /**
   * Return what is drawn at a place (CSS pixels), or a few pixels beside: the index of a point or
   * vertex (-1: nothing) and whether it is of a face that was filled.
   */
  pick(x, y) {
    const {gl, canvas} = this, reach = 6, side = 2 * reach + 1;
    const sharp = canvas.width / canvas.clientWidth;
    const target = gl.createFramebuffer(), colour = gl.createTexture();
    const depth = gl.createRenderbuffer();
    gl.bindTexture(gl.TEXTURE_2D, colour);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, side, side, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, side, side);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    const left = Math.round(x * sharp), bottom = Math.round(canvas.height - y * sharp);
    gl.viewport(reach - left, reach - bottom, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawLayer(canvas.width, canvas.height, MODES.pick);
    const bytes = new Uint8Array(4 * side * side);
    gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(target);
    gl.deleteTexture(colour);
    gl.deleteRenderbuffer(depth);
    let best = {index: -1, filled: false}, nearest = Infinity;
    for (let k = 0; k < side * side; k++) {
      const id = bytes[4 * k] | (bytes[4 * k + 1] << 8) | (bytes[4 * k + 2] << 16);
      const away = (k % side - reach) ** 2 + (Math.floor(k / side) - reach) ** 2;
      if (id > 0 && away < nearest) {
        [best, nearest] = [{index: id - 1, filled: bytes[4 * k + 3] === 2}, away];
      }
    }
    return best;
  }

  /** What is known of a point of the layer shown: position and residual in the object's units. */
  facts(index) {
    const layer = this.object.layers[this.state.layer], {arrays} = layer;
    const position = [0, 1, 2].map((k) => this.object.origin[k]
      + arrays.position[3 * index + k] / 65535 * this.object.edge);
    const view = arrays.view ? arrays.view[index] : NONE;
    const raw = arrays.residual ? arrays.residual[index] : NONE;
    return {
      position, view: view === NONE ? null : view,
      residual: raw === NONE ? null : (raw / 4095 - 1) * layer.limit,
      state: arrays.state ? arrays.state[index] : null,
    };
  }
}

const ARROW = {long: 0.36, neck: 0.16};

/** Triangles of an arrow from z = long to z = 0, in radii of the object. */
function arrowShape() {
  const sides = 20, out = [];
  const ring = (k, radius, z) => {
    const angle = 2 * Math.PI * k / sides;
    return [radius * Math.cos(angle), radius * Math.sin(angle), z];
  };
  for (let k = 0; k < sides; k++) {
    const {long: tail, neck} = ARROW, thin = 0.018, wide = 0.06, tip = 0;
    out.push(...ring(k, thin, tail), ...ring(k + 1, thin, tail), ...ring(k, thin, neck));
    out.push(...ring(k, thin, neck), ...ring(k + 1, thin, tail), ...ring(k + 1, thin, neck));
    out.push(...ring(k, wide, neck), ...ring(k + 1, wide, neck), 0, 0, tip);
    out.push(...ring(k, wide, neck), 0, 0, neck, ...ring(k + 1, wide, neck));
  }
  return new Float32Array(out);
}
