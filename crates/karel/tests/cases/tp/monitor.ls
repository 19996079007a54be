/PROG  MONITOR
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  MONITOR GUARD ;
   2:  WAIT .50(sec) ;
   3:  R[1]=1 ;
   4:  MONITOR GUARD ;
   5:  WAIT .10(sec) ;
   6:  MONITOR END GUARD ;
   7:  R[4]=2 ;
   8:  WAIT .10(sec) ;
   9:  MONITOR NOWHERE ;
/POS
/END
--> load guard.ls
--> load action.ls
