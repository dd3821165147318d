// Who is at the session, what this page may do there, and the invitations to it.
import { command, type Command } from './commands';
import type { Invitation, Participant, Role, Size, Welcome } from './told';

export class People {
  /** Everyone at the session, this page among them. */
  participants = $state.raw<Participant[]>([]);
  invitations = $state.raw<Invitation[]>([]);
  /** The invitation that was just made here, with its link; the server tells its token once. */
  made = $state.raw<Invitation | null>(null);
  /** How large the pictures of those who may only look may be; 0 and 0: as large as the server allows. */
  viewerSize = $state.raw<Size>({ width: 0, height: 0 });
  /** This page may look and not change. */
  viewOnly = $state.raw(false);
  /** Whether this page came by a link; it cannot take control by itself. */
  invited = $state.raw(false);
  /** Which of the participants this page is. */
  me = $state.raw(0n);

  constructor(private readonly send: (body: Command) => void) {}

  setRole(participant: bigint, role: Role): void {
    this.send(command.setRole(participant, role));
  }
  setViewerSize(size: Size): void {
    this.send(command.setViewerSize(size));
  }
  invite(role: Role, seconds: number, name: string): void {
    this.made = null;
    this.send(command.createInvitation(role, seconds, name));
  }
  revoke(id: string): void {
    if (this.made?.id === id) this.made = null;
    this.send(command.revokeInvitation(id));
  }
  listInvitations(): void {
    if (!this.viewOnly) this.send(command.listInvitations());
  }

  welcomed({ role, participant, resumeToken }: Pick<Welcome, 'role' | 'participant' | 'resumeToken'>): void {
    this.viewOnly = role === 'viewer';
    this.me = participant ?? 0n;
    this.invited = resumeToken === '';
  }
  /** Whether this page may do more or less than before. */
  told(participants: Participant[], viewerSize: Size): boolean {
    this.participants = participants;
    this.viewerSize = viewerSize;
    const role = participants.find(({ id }) => id === this.me)?.role;
    const changed = role !== undefined && (role === 'viewer') !== this.viewOnly;
    if (changed) this.viewOnly = !this.viewOnly;
    return changed;
  }
  /** An invitation that this page asked for. */
  toldMade(invitation: Invitation): void {
    this.made = invitation;
    this.listInvitations();
  }
}
