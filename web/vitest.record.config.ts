import base from './vitest.e2e.config';

// Not a test: it makes pictures to look at. It needs what the browser tests need, and the target isostrata-shaped-link.
export default { ...base, test: { ...base.test, include: ['**/*.record.ts'] } };
