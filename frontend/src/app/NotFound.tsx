import { ButtonLink } from "@/components/controls/Button";
import { Empty } from "@/components/feedback/States";

/** No page has this address. */
export function NotFound() {
  return (
    <Empty title="There is no such page" actions={<ButtonLink to="/">All behaviours</ButtonLink>}>
      <p>The address is wrong, or what it showed was deleted.</p>
    </Empty>
  );
}
