// A task program that shows a panel.

import { spawn } from 'node:child_process';

/** How a program with a panel is started; gives the address that it prints, and how to end it. */
export const starting = (program) => async (words, variables = {}) => {
  const child = spawn(program, words, { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, ...variables } });
  let said = '';
  const ended = new Promise((resolve) => child.on('close', resolve));
  const address = new Promise((resolve, reject) => {
    const hear = (text) => {
      said += text;
      const found = said.match(/panel: (https?:\S+?#token=[0-9a-f]{32})/);
      if (found) resolve(found[1]);
    };
    child.stdout.on('data', hear);
    child.stderr.on('data', hear);
    ended.then(() => reject(new Error(`it has ended:\n${said}`)));
    setTimeout(() => reject(new Error(`no address:\n${said}`)), 60000).unref();
  });
  return { address: await address, ended, said: () => said, end: (signal = 'SIGTERM') => { child.kill(signal); return ended; } };
};
