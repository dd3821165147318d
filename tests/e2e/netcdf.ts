// A file of netCDF's classic format (CDF-1, from its specification), of numbers alone.

interface Variable {
  name: string;
  dimensions: string[];
  attributes?: Record<string, string>;
  values: number[]; // doubles
}

const int = (value: number) => {
  const bytes = Buffer.alloc(4);
  bytes.writeInt32BE(value);
  return bytes;
};
const padded = (bytes: Buffer) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)]);
const text = (words: string) => Buffer.concat([int(Buffer.byteLength(words)), padded(Buffer.from(words))]);
const list = (tag: number, items: Buffer[]) => Buffer.concat([int(items.length ? tag : 0), int(items.length), ...items]);

export function netcdf(dimensions: Record<string, number>, variables: Variable[]): Buffer {
  const names = Object.keys(dimensions);
  const data = variables.map(({ values }) => {
    const bytes = Buffer.alloc(values.length * 8);
    values.forEach((value, i) => bytes.writeDoubleBE(value, i * 8));
    return bytes;
  });
  const header = (begin: number) => {
    const of = variables.map(({ name, dimensions: along, attributes = {} }, i) => {
      const written = Object.entries(attributes).map(([key, words]) => Buffer.concat([text(key), int(2), text(words)]));
      const at = begin + data.slice(0, i).reduce((sum, bytes) => sum + bytes.length, 0);
      return Buffer.concat([text(name), int(along.length), ...along.map((dimension) => int(names.indexOf(dimension))), list(12, written), int(6), int(data[i]!.length), int(at)]);
    });
    const lengths = names.map((name) => Buffer.concat([text(name), int(dimensions[name]!)]));
    return Buffer.concat([Buffer.from('CDF\x01'), int(0), list(10, lengths), list(12, []), list(11, of)]);
  };
  return Buffer.concat([header(header(0).length), ...data]);
}
