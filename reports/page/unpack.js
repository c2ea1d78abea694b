/* The packed arrays of the page, see pack.py: base64 -> deflated bytes -> typed arrays. */

const KINDS = { u1: Uint8Array, u2: Uint16Array, i2: Int16Array, u4: Uint32Array, f4: Float32Array };

function decoded(text) {
  const plain = atob(text.trim().replace(/-/g, "+").replace(/_/g, "/"));
  const bytes = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) bytes[i] = plain.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/* Sums differences along the last axis; low bytes come first, then high bytes. */
function summed(bytes, shape, Kind) {
  const count = bytes.length / 2, length = shape[shape.length - 1];
  const out = new Kind(count), whole = new Uint16Array(out.buffer);
  for (let first = 0; first < count; first += length) {
    let value = 0;
    for (let i = first; i < first + length; i++) {
      value += bytes[i] + (bytes[count + i] << 8);
      whole[i] = value;
    }
  }
  return out;
}

async function unpack(contents, text) {
  const bytes = await inflated(decoded(text)), out = {};
  let at = 0;
  for (const item of contents) {
    const Kind = KINDS[item.kind], count = item.shape.reduce((a, b) => a * b, 1);
    const part = bytes.slice(at, at + count * Kind.BYTES_PER_ELEMENT);
    out[item.name] = item.history ? summed(part, item.shape, Kind) : new Kind(part.buffer);
    at += part.length;
  }
  return out;
}
