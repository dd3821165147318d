/** Whether the person has asked for little motion. */
export const calm = (): boolean => window.matchMedia('(prefers-reduced-motion: reduce)').matches;
