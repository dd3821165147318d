// A message of the server's, as its bytes.
import { create, toBinary, type MessageInitShape } from '@bufbuild/protobuf';
import { ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';

export type Body = NonNullable<MessageInitShape<typeof ServerMessageSchema>['body']>;

export const serverSays = (body: Body): Uint8Array => toBinary(ServerMessageSchema, create(ServerMessageSchema, { body }));
