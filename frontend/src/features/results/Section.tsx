import { type ReactNode, useEffect, useRef, useState } from "react";
import { useLocation } from "react-router";

import { Icon } from "@/components/controls/Icon";

import styles from "./Section.module.css";

interface SectionProps {
  /** That links lead to. */
  id: string;
  title: string;
  /** Whether it is unfolded at first. */
  open: boolean;
  children: ReactNode;
}

/** A part of the page behind its heading. A link to it unfolds it; its content is made by then. */
export function Section({ id, title, open, children }: SectionProps) {
  const { hash, key } = useLocation();
  const isLed = hash === `#${id}`;
  const [isOpen, setIsOpen] = useState(open || isLed);
  // A changed fragment in the address bar keeps the key.
  const visit = `${key}${hash}`;
  const [followed, setFollowed] = useState(visit);
  const section = useRef<HTMLElement>(null);
  if (visit !== followed) {
    setFollowed(visit);
    if (isLed) setIsOpen(true);
  }
  useEffect(() => {
    if (isLed) section.current?.scrollIntoView();
  }, [isLed, key]);
  return (
    <section ref={section} id={id} className={styles.section} aria-labelledby={`${id}-title`}>
      <details open={isOpen}>
        <summary
          onClick={(event) => {
            event.preventDefault();
            setIsOpen(!isOpen);
          }}
        >
          <h2 id={`${id}-title`}>{title}</h2>
          <Icon name="chevronDown" />
        </summary>
        {isOpen && <div className={styles.body}>{children}</div>}
      </details>
    </section>
  );
}
