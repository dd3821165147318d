import base from './vitest.e2e.config';

// Not tests: `slow-link` makes pictures to look at, by the target isostrata-shaped-link; `portal` is run by deploy/prove-ondemand.
export default { ...base, test: { ...base.test, include: ['**/*.record.ts'] } };
