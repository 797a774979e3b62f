// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
'use strict';
/*
 * Geometry as report_pack.py packs it. Inflated here, not by DecompressionStream: browsers have
 * that since 2023 only, and it answers later, so that there would be two ways to keep right.
 */

/** Undo deflate (RFC 1951); `size` is that of the result. */
function inflated(source, size) {
  const out = new Uint8Array(size);
  let at = 0, held = 0, count = 0, end = 0;
  const fill = (n) => { for (; count < n; count += 8) held |= source[at++] << count; };
  const bits = (n) => {
    fill(n);
    const value = held & ((1 << n) - 1);
    held >>>= n;
    count -= n;
    return value;
  };
  const tableOf = (lengths) => {
    const most = Math.max(1, ...lengths), table = new Uint16Array(1 << most);
    for (let size = 1, code = 0; size <= most; size++, code <<= 1) {
      lengths.forEach((length, symbol) => {
        if (length !== size) return;
        let first = 0;
        for (let k = 0; k < size; k++) first |= ((code >> k) & 1) << (size - 1 - k);
        for (let k = first; k < table.length; k += 1 << size) table[k] = symbol << 4 | size;
        code++;
      });
    }
    return {table, most};
  };
  const next = ({table, most}) => {
    fill(most);
    const entry = table[held & (table.length - 1)];
    held >>>= entry & 15;
    count -= entry & 15;
    return entry >> 4;
  };
  const copy = (literal, distance) => {
    for (;;) {
      const symbol = next(literal);
      if (symbol < 256) out[end++] = symbol;
      else if (symbol === 256) return;
      else {
        const k = symbol - 257;
        const length = k < 8 ? k + 3 : k === 28 ? 258
          : ((k & 3) + 4 << (k >> 2) - 1) + 3 + bits((k >> 2) - 1);
        const far = next(distance);
        const back = far < 2 ? far + 1
          : ((far & 1) + 2 << (far >> 1) - 1) + 1 + bits((far >> 1) - 1);
        for (const stop = end + length; end < stop; end++) out[end] = out[end - back];
      }
    }
  };
  const coded = () => {  // a block with tables of its own
    const [literals, distances, sizes] = [bits(5) + 257, bits(5) + 1, bits(4) + 4];
    const order = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
    const first = new Array(19).fill(0), lengths = [];
    for (let k = 0; k < sizes; k++) first[order[k]] = bits(3);
    const table = tableOf(first);
    while (lengths.length < literals + distances) {
      const symbol = next(table);
      if (symbol < 16) {
        lengths.push(symbol);
        continue;
      }
      const value = symbol === 16 ? lengths[lengths.length - 1] : 0;
      const times = symbol === 16 ? 3 + bits(2) : symbol === 17 ? 3 + bits(3) : 11 + bits(7);
      for (let k = 0; k < times; k++) lengths.push(value);
    }
    copy(tableOf(lengths.slice(0, literals)), tableOf(lengths.slice(literals)));
  };
  for (let last = 0; !last;) {
    last = bits(1);
    const kind = bits(2);
    if (kind === 0) {
      at -= count >> 3;
      held = count = 0;
      const length = source[at] | source[at + 1] << 8;
      out.set(source.subarray(at + 4, at + 4 + length), end);
      at += 4 + length;
      end += length;
    } else if (kind === 1) {
      copy(tableOf(Array.from({length: 288}, (_, k) => (k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8))),
           tableOf(new Array(30).fill(5)));
    } else coded();
  }
  return out;
}

/** Numbers in `columns` columns, each byte of each column by itself; with steps, summed up. */
function unpacked(text, Kind, count, columns, steps) {
  const raw = atob(text), bytes = new Uint8Array(raw.length), width = Kind.BYTES_PER_ELEMENT;
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  const planes = inflated(bytes, count * columns * width), out = new Kind(count * columns);
  for (let c = 0; c < columns; c++) {
    for (let b = 0; b < width; b++) {
      const from = (c * width + b) * count;
      for (let k = 0; k < count; k++) out[k * columns + c] |= planes[from + k] << 8 * b;
    }
    for (let k = 1; steps && k < count; k++) out[k * columns + c] += out[(k - 1) * columns + c];
  }
  return out;
}

/** Corners of triangles: steps from that before, and from the first corner; signs in bit 0. */
function unpackedFaces(text, triangles) {
  const faces = unpacked(text, Uint32Array, 3 * triangles, 1, false);
  let first = 0;
  for (let k = 0; k < faces.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map((j) => (faces[k + j] >>> 1) ^ -(faces[k + j] & 1));
    first += a;
    faces[k] = first;
    faces[k + 1] = first + b;
    faces[k + 2] = first + c;
  }
  return faces;
}
