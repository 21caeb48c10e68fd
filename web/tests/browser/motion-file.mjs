/** Motions as numpy writes them, made for the cases. */

import { crc32 } from "node:zlib";

/** An array as an `.npy` file; a number alone has no dimensions. */
function npy(numbers, shape) {
  const type = numbers instanceof Float64Array ? "<f8" : "<f4";
  const dimensions = shape.map((count) => `${count},`).join("");
  const header = `{'descr': '${type}', 'fortran_order': False, 'shape': (${dimensions}), }`;
  // The numbers begin at a multiple of 64 bytes.
  const length = Math.ceil((10 + header.length + 1) / 64) * 64 - 10;
  const start = Buffer.alloc(10);
  start.write("\x93NUMPY\x01\x00", "latin1");
  start.writeUInt16LE(length, 8);
  const { buffer, byteOffset, byteLength } = numbers;
  return Buffer.concat([
    start,
    Buffer.from(`${header.padEnd(length - 1)}\n`),
    Buffer.from(buffer, byteOffset, byteLength),
  ]);
}

/** Files in a zip, not compressed. */
function zip(files) {
  const parts = [];
  const directory = [];
  let offset = 0;
  for (const [name, bytes] of Object.entries(files)) {
    const about = Buffer.alloc(26);
    about.writeUInt16LE(20, 0);
    about.writeUInt32LE(crc32(bytes), 10);
    about.writeUInt32LE(bytes.length, 14);
    about.writeUInt32LE(bytes.length, 18);
    about.writeUInt16LE(name.length, 22);
    const place = Buffer.alloc(14);
    place.writeUInt32LE(offset, 10);
    directory.push(Buffer.from("PK\x01\x02\x14\x00", "latin1"), about, place, Buffer.from(name));
    const entry = [Buffer.from("PK\x03\x04", "latin1"), about, Buffer.from(name), bytes];
    parts.push(...entry);
    offset += entry.reduce((sum, { length }) => sum + length, 0);
  }
  const count = Object.keys(files).length;
  const end = Buffer.alloc(22);
  end.write("PK\x05\x06", "latin1");
  end.writeUInt16LE(count, 8);
  end.writeUInt16LE(count, 10);
  end.writeUInt32LE(Buffer.concat(directory).length, 12);
  end.writeUInt32LE(offset, 16);
  return Buffer.concat([...parts, ...directory, end]);
}

/** A motion of AMASS's kind in which elbows swing, every ten seconds as before, and the root goes to and fro. */
export function longMotion(seconds, framesPerSecond) {
  const count = seconds * framesPerSecond + 1;
  const poses = new Float32Array(72 * count);
  const translations = new Float32Array(3 * count);
  for (let frame = 0; frame < count; frame += 1) {
    const swing = Math.sin((2 * Math.PI * frame) / (10 * framesPerSecond));
    for (const joint of [18, 19]) poses[72 * frame + 3 * joint + 1] = swing;
    translations[3 * frame] = swing / 2;
    translations[3 * frame + 1] = 0.95;
  }
  return zip({
    "poses.npy": npy(poses, [count, 72]),
    "trans.npy": npy(translations, [count, 3]),
    "mocap_framerate.npy": npy(Float64Array.of(framesPerSecond), []),
  });
}
