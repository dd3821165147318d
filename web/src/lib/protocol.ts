// What both directions of the protocol share: its versions, the names of its enumerations, and what is left of a message without its type.
import type { Message } from '@bufbuild/protobuf';
import { Role as WireRole } from '../gen/isostrata/v1/isostrata_pb';

export const subprotocol = 'isostrata.v1';
export const protocolMajor = 1;
export const protocolMinor = 2;

/** The page calls an enumeration's values by their names on the wire, in small letters. other: what is meant by a value that is not said, or not known. */
export function names<Wire extends Record<string, string | number>, Other extends string>(wire: Wire, other: Other) {
  type Name = Lowercase<Exclude<keyof Wire & string, 'UNSPECIFIED'>> | Other;
  const valueOf = (name: string) => wire[String(name).toUpperCase()];
  return {
    wire: (name: Name) => valueOf(typeof valueOf(name) === 'number' ? name : other) as Wire[keyof Wire],
    name: (value: number) => (value && value in wire ? String(wire[value]).toLowerCase() : other) as Name,
  };
}

/** The fields of a message, to be taken over as they are and perhaps sent back some day. */
export function plain<M extends Message>({ $typeName, $unknown, ...fields }: M) {
  return fields;
}

export const roles = names(WireRole, 'controller');
